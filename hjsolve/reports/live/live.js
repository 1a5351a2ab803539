"use strict";
// The live part of a report: reads the tables beside it, follows the sliders, moves one point on three drawings.
// Nothing is fetched; the tables are Chebyshev coefficients, the time law is a sine series (see docs/live.md).
(() => {
  const data = JSON.parse(document.getElementById("live-data").textContent);
  const root = document.getElementById("live");
  const at = (id) => document.getElementById(`live-${id}`);
  const settings = data.sliders.map((s) => s.value);
  let motion, time = 0, playing = false, speed = 1, last = null, curves;

  // ------------------------------------------------------------------ numbers
  const chebyshev = (n, u) => {
    const T = [1, u];
    for (let k = 2; k < n; k++) T.push(2 * u * T[k - 1] - T[k - 2]);
    return T;
  };
  const evaluate = (values) => {
    const u = data.sliders.map((s, i) => Math.max(-1, Math.min(1, (2 * values[i] - s.low - s.high) / (s.high - s.low))));
    const [X, Y] = (u.length === 1 ? [0, u[0]] : u).map((v) => chebyshev(data.size, v));
    const found = {};
    for (const name of Object.keys(data.columns)) {
      found[name] = data.columns[name].map((table) => {
        let sum = 0;
        for (let i = 0; i < table.length; i++) {
          let row = 0;
          for (let j = 0; j < table[i].length; j++) row += table[i][j] * Y[j];
          sum += X[i] * row;
        }
        return sum;
      });
    }
    return found;
  };
  const sines = (c, chi) => {
    let sum = c[0] * chi;
    for (let k = 1; k < c.length; k++) sum += (c[k] / k) * Math.sin(k * chi);
    return sum;
  };
  const cosines = (c, chi) => {
    let sum = c[0];
    for (let k = 1; k < c.length; k++) sum += c[k] * Math.cos(k * chi);
    return sum;
  };
  const state = (m, t) => {
    const mean = m.t[0];
    const cycles = Math.floor(t / (2 * Math.PI * mean));
    const rest = t - cycles * 2 * Math.PI * mean;
    let low = 0, high = 2 * Math.PI, chi = rest / mean;
    for (let n = 0; n < 60; n++) {
      const miss = sines(m.t, chi) - rest;
      if (miss > 0) high = chi; else low = chi;
      const next = chi - miss / cosines(m.t, chi);
      const step = (next > low && next < high ? next : (low + high) / 2) - chi;
      chi += step;
      if (Math.abs(step) < 1e-14) break;
    }
    const middle = (m.a[0] + m.b[0]) / 2, half = (m.b[0] - m.a[0]) / 2;
    const found = { q: middle - half * Math.cos(chi), p: half * Math.sin(chi) * cosines(m.root, chi), angles: {} };
    for (const name of data.angles) found.angles[name] = sines(m[name], chi + 2 * Math.PI * cycles);
    return found;
  };
  const period = () => 2 * Math.PI * motion.t[0];
  const phases = (t) => [(2 * Math.PI * t) / period(), (2 * Math.PI * motion[data.torus][0] * t) / period()];
  const ring = (a, b) => [(1 + 0.42 * Math.cos(a)) * Math.cos(b), (1 + 0.42 * Math.cos(a)) * Math.sin(b), 0.42 * Math.sin(a)];
  const squared = (k, values) => {
    const [x, y] = values.length === 1 ? [0, values[0]] : values;
    let sum = 0;
    for (const term of data.well.terms) sum += term.values[k] * x ** term.i * y ** term.j;
    return sum;
  };
  const place = (s) => {
    const { kind, names, up } = data.where;
    const v = (n) => (n === data.coordinate ? s.q : s.angles[n]);
    const [a, b, c] = names.map(v);
    if (kind === "polar") return [a * Math.cos(b), a * Math.sin(b), 0];
    if (kind === "parabolic") return [(a * a - b * b) / 2, a * b, 0];
    if (kind === "spherical")
      return [a * Math.sin(b) * Math.cos(c), a * Math.sin(b) * Math.sin(c), a * Math.cos(b)];
    if (kind === "colatitude") return [Math.sin(a) * Math.cos(b), Math.sin(a) * Math.sin(b), up * Math.cos(a)];
    if (kind === "elevation") return [Math.cos(a) * Math.cos(b), Math.cos(a) * Math.sin(b), up * Math.sin(a)];
    return [a, b === undefined ? s.p : b, 0];
  };

  // ------------------------------------------------------------------ drawing
  let view = { azimuth: -0.9, elevation: 0.42 };
  const solid = ["spherical", "colatitude", "elevation"].includes(data.where.kind);
  const project = ([x, y, z], turned = solid) => {
    if (!turned) return [x, y];
    const { azimuth: a, elevation: e } = view;
    const forward = x * Math.cos(a) + y * Math.sin(a);
    return [-x * Math.sin(a) + y * Math.cos(a), z * Math.cos(e) - forward * Math.sin(e)];
  };
  const colour = (name) => getComputedStyle(root).getPropertyValue(`--${name}`).trim() || "#666";
  const board = (canvas) => {
    const ratio = window.devicePixelRatio || 1;
    const box = canvas.getBoundingClientRect();
    const width = Math.round(box.width * ratio), height = Math.round(box.height * ratio);
    if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
    const pen = canvas.getContext("2d");
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.clearRect(0, 0, box.width, box.height);
    return { pen, width: box.width, height: box.height };
  };
  const range = (values, equal) => {
    const good = values.filter(Number.isFinite);
    const low = Math.min(...good), high = Math.max(...good), room = 0.08 * (high - low || 1);
    return equal ? [Math.min(low, -high) - room, Math.max(high, -low) + room] : [low - room, high + room];
  };
  const frame = (canvas, x, y, equal) => {
    const b = board(canvas), left = 34, bottom = 26, top = 18;
    let sx = (b.width - left - 8) / (x[1] - x[0]), sy = (b.height - bottom - top) / (y[1] - y[0]);
    if (equal) sx = sy = Math.min(sx, sy);
    const cx = left + (b.width - left - 8) / 2 - (sx * (x[0] + x[1])) / 2;
    const cy = top + (b.height - bottom - top) / 2 + (sy * (y[0] + y[1])) / 2;
    return { ...b, left, bottom, top, px: (v) => cx + sx * v, py: (v) => cy - sy * v };
  };
  const line = (f, points, name, width, dash = []) => {
    f.pen.beginPath();
    f.pen.strokeStyle = colour(name);
    f.pen.lineWidth = width;
    f.pen.setLineDash(dash);
    let down = false;
    for (const [x, y] of points) {
      if (!Number.isFinite(y)) { down = false; continue; }
      if (down) f.pen.lineTo(f.px(x), f.py(y)); else f.pen.moveTo(f.px(x), f.py(y));
      down = true;
    }
    f.pen.stroke();
    f.pen.setLineDash([]);
  };
  const dot = (f, x, y, name, size) => {
    f.pen.beginPath();
    f.pen.fillStyle = colour(name);
    f.pen.arc(f.px(x), f.py(y), size, 0, 2 * Math.PI);
    f.pen.fill();
  };
  const labels = (f, across, up, ends) => {
    f.pen.fillStyle = colour("soft");
    f.pen.font = "12px system-ui, sans-serif";
    f.pen.textAlign = "right";
    f.pen.fillText(across, f.width - 8, f.height - 2);
    f.pen.textAlign = "left";
    f.pen.fillText(up, 4, 12);
    if (ends) {
      f.pen.textAlign = "center";
      for (const v of ends) f.pen.fillText(v.toPrecision(4), f.px(v), f.height - 13);
    }
  };
  const change = () => {
    motion = evaluate(settings);
    const T = period(), many = 240;
    const loop = [...Array(many + 1).keys()].map((k) => state(motion, (k / many) * T));
    const cycles = data.angles.length ? 6 : 1;
    const path = [...Array(cycles * many + 1).keys()].map((k) => place(state(motion, (k / many) * T)));
    const level = settings[settings.length - 1];
    const V = data.well.q.map((q, k) => {
      const P = squared(k, settings), slope = squared(k, [...settings.slice(0, -1), level + 1]) - P;
      return [q, level - P / slope];
    });
    curves = { loop: loop.map((s) => [s.q, s.p]), path, V, level };
    at("numbers").innerHTML = "";
    const rows = [
      ...data.sliders.map((s, i) => [s.label, settings[i]]),
      [`lower turning point of ${data.label}`, motion.a[0]], [`upper turning point of ${data.label}`, motion.b[0]],
      ["period", T], ...data.angles.map((n) => [`gain of ${data.labels[n]} per period`, 2 * Math.PI * motion[n][0]]),
    ];
    for (const [name, value] of rows) {
      const row = at("numbers").insertRow();
      const head = document.createElement("th");
      head.scope = "row";
      head.textContent = name;
      row.append(head);
      row.insertCell().textContent = value.toPrecision(7);
    }
    data.sliders.forEach((s, i) => {
      at(`value-${i}`).textContent = settings[i].toPrecision(5);
      at(`slider-${i}`).setAttribute("aria-valuetext", `${s.label} = ${settings[i].toPrecision(5)}`);
    });
    draw();
  };
  const draw = () => {
    const s = state(motion, time);
    const half = (motion.b[0] - motion.a[0]) / 2;
    const wide = range([motion.a[0] - 0.35 * half, motion.b[0] + 0.35 * half]);
    const inside = curves.V.filter(([q]) => q >= motion.a[0] && q <= motion.b[0]).map((p) => p[1]);
    const bottom = Math.min(curves.level, ...inside), depth = curves.level - bottom || 1;
    let f = frame(at("well"), wide, [bottom - 0.15 * depth, curves.level + 0.6 * depth]);
    f.pen.save();
    f.pen.beginPath();
    f.pen.rect(f.left, f.top, f.width - f.left, f.height - f.top - f.bottom);
    f.pen.clip();
    line(f, curves.V.map(([q, v]) => [q, v < curves.level + 3 * depth ? v : NaN]), "ink", 1.6);
    line(f, [[motion.a[0], curves.level], [motion.b[0], curves.level]], "red", 2);
    f.pen.restore();
    dot(f, s.q, curves.level, "red", 5);
    labels(f, data.label, `effective potential, ${data.level}`, [motion.a[0], motion.b[0]]);
    f = frame(at("phase"), range(curves.loop.map((p) => p[0])), range(curves.loop.map((p) => p[1])));
    line(f, curves.loop, "red", 1.6);
    dot(f, s.q, s.p, "red", 5);
    labels(f, data.label, data.momentum, [motion.a[0], motion.b[0]]);
    const flat = curves.path.map((p) => project(p)), now = project(place(s));
    const span = data.ball ? [-1.08, 1.08] : null;
    f = frame(at("orbit"), span || range(flat.map((p) => p[0]), data.centred), span || range(flat.map((p) => p[1]), data.centred), data.equal);
    const ring = [...Array(97).keys()].map((k) => [Math.cos((k * Math.PI) / 48), Math.sin((k * Math.PI) / 48)]);
    if (data.ball) line(f, ring, "rule", 1);
    line(f, flat, "red", 1.2);
    if (data.centred) dot(f, 0, 0, "ink", 3);
    dot(f, now[0], now[1], "red", 5);
    labels(f, data.axes[0], data.axes[1]);
    if (data.torus) torus();
    if (data.map) map();
    at("time").textContent = `${data.clock} = ${time.toPrecision(4)}`;
  };

  const torus = () => {
    const f = frame(at("torus"), [-1.5, 1.5], [-1.5, 1.5], true);
    const around = [...Array(61).keys()].map((k) => (k * Math.PI) / 30);
    for (let k = 0; k < 12; k++) {
      line(f, around.map((v) => project(ring((k * Math.PI) / 6, v), true)), "rule", 0.6);
      line(f, around.map((v) => project(ring(v, (k * Math.PI) / 6), true)), "rule", 0.6);
    }
    const T = period();
    const path = [...Array(601).keys()].map((k) => project(ring(...phases(time + (k / 60 - 10) * T)), true));
    line(f, path, "red", 1.2);
    dot(f, ...project(ring(...phases(time)), true), "red", 5);
    labels(f, "", `torus: ${data.label} round the tube, ${data.labels[data.torus]} along`);
  };
  const map = () => {
    const [x, y] = data.map.window, [a, b] = data.sliders;
    const f = frame(at("map"), x, y);
    f.pen.save();
    f.pen.beginPath();
    f.pen.rect(f.left, f.top, f.width - f.left, f.height - f.top - f.bottom);
    f.pen.clip();
    for (const curve of data.map.curves) line(f, curve.map((p) => p || [NaN, NaN]), "ink", 1.4);
    line(f, [[a.low, b.low], [a.high, b.low], [a.high, b.high], [a.low, b.high], [a.low, b.low]], "soft", 1, [3, 3]);
    f.pen.restore();
    dot(f, settings[0], settings[1], "red", 5);
    labels(f, a.label, `${b.label}, map of all motions`);
    return f;
  };

  // ------------------------------------------------------------------ controls
  const step = (now) => {
    if (!playing) return;
    if (last !== null) time += ((now - last) / 1000) * speed * (period() / 4);
    last = now;
    draw();
    requestAnimationFrame(step);
  };
  const play = (on) => {
    playing = on;
    last = null;
    at("play").textContent = on ? "Pause" : "Play";
    at("play").setAttribute("aria-pressed", String(on));
    if (on) requestAnimationFrame(step);
  };
  data.sliders.forEach((s, i) => {
    at(`slider-${i}`).addEventListener("input", (event) => {
      settings[i] = s.low + (s.high - s.low) * (Number(event.target.value) / 1000);
      change();
    });
  });
  at("play").addEventListener("click", () => play(!playing));
  at("speed").addEventListener("change", (event) => { speed = Number(event.target.value); });
  at("start").addEventListener("click", () => { time = 0; draw(); });
  const orbit = at("orbit");
  const turn = (dx, dy) => {
    view = { azimuth: view.azimuth - dx / 120, elevation: Math.max(-1.5, Math.min(1.5, view.elevation + dy / 120)) };
    draw();
  };
  const arrows = (event, then) => {
    const move = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
    if (move) { event.preventDefault(); then(...move); }
  };
  for (const turning of [...(solid ? [orbit] : []), ...(data.torus ? [at("torus")] : [])]) {
    turning.addEventListener("pointermove", (event) => { if (event.buttons) turn(event.movementX, event.movementY); });
    turning.addEventListener("keydown", (event) => arrows(event, (x, y) => turn(12 * x, 12 * y)));
  }
  const choose = (values) => {
    data.sliders.forEach((s, i) => {
      settings[i] = Math.min(s.high, Math.max(s.low, values[i]));
      at(`slider-${i}`).value = (1000 * (settings[i] - s.low)) / (s.high - s.low);
    });
    change();
  };
  if (data.map) {
    const clicked = (event) => {
      const f = map(), box = at("map").getBoundingClientRect(), [x, y] = data.map.window;
      const share = (v, low, high) => (v - low) / (high - low);
      const across = share(event.clientX - box.left, f.px(x[0]), f.px(x[1])), up = share(event.clientY - box.top, f.py(y[0]), f.py(y[1]));
      choose([x[0] + across * (x[1] - x[0]), y[0] + up * (y[1] - y[0])]);
    };
    at("map").addEventListener("pointerdown", clicked);
    at("map").addEventListener("pointermove", (event) => { if (event.buttons) clicked(event); });
    at("map").addEventListener("keydown", (event) => arrows(event, (x, y) =>
      choose(data.sliders.map((s, i) => settings[i] + ((i ? -y : x) * (s.high - s.low)) / 100))));
  }
  window.addEventListener("resize", draw);
  window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
  window.hjsolveLive = {
    state: (t) => state(motion, t), phases, motion: () => motion, settings, bounds: data.bounds, draw,
    set: (values) => { values.forEach((v, i) => { settings[i] = v; }); change(); }, seek: (t) => { time = t; draw(); },
  };
  root.hidden = false;
  change();
})();
