"use strict";
// The live part of a report: reads the tables next to it, follows the sliders, moves one point on three drawings.
// Nothing is fetched; the tables are Chebyshev coefficients, the time law is a sine series (see docs/live.md).
(() => {
  const data = JSON.parse(document.getElementById("live-data").textContent);
  const root = document.getElementById("live");
  const at = (id) => document.getElementById(`live-${id}`);
  const settings = data.sliders.map((s) => s.value);
  let motion, time = 0, playing = false, speed = 1, last = null, curves, samples;

  // ------------------------------------------------------------------ numbers
  const numbers = hjsolveNumbers(data), many = data.coordinates.length;
  const state = (t) => numbers.state(motion, t);
  const period = (k) => (2 * Math.PI) / Math.abs(motion.rates[k]);
  const longest = () => Math.max(...data.coordinates.map((_, k) => period(k)));
  const shortest = () => Math.min(...data.coordinates.map((_, k) => period(k)));
  const shown = (value, digits) => value.toPrecision(digits).replace("-", "−");
  const turn = (x) => x - 2 * Math.PI * Math.round(x / (2 * Math.PI));
  const phases = (t) => [motion.begin[0] + motion.rates[0] * t,
    data.torus.ignorable ? motion.drift[data.torus.second] * t : motion.begin[data.torus.second] + motion.rates[data.torus.second] * t];
  const ring = (a, b) => [(1 + 0.42 * Math.cos(a)) * Math.cos(b), (1 + 0.42 * Math.cos(a)) * Math.sin(b), 0.42 * Math.sin(a)];
  const place = (s, t) => {
    if (!data.where.tape) return [t, s.q[data.coordinates[0].name], 0];
    const found = numbers.run(data.where.tape, [...data.where.names.map((name) => s.q[name]), ...motion.inputs]);
    return found.length < 3 ? [...found, 0] : found;
  };

  // ------------------------------------------------------------------ drawing
  let view = { azimuth: -0.9, elevation: 0.42 };
  const solid = data.where.solid;
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
    const b = board(canvas), left = 46, bottom = 34, top = 22;
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
  // One letter and its index, but not the letters that name regions of the map.
  const NAME = /(?<![\p{L}\p{N}])(?![A-D](?![_\p{L}]))(\p{L})(?:_([\p{L}\p{N}]+))?(?![\p{L}\p{N}])/u;
  // A name with its index set low: "p_φ" is p with a small φ below the line; the text begins or ends at x.
  const write = (f, text, x, y, align = "left") => {
    const parts = text.split(NAME).map((part, m) => m % 3 === 2
      ? { text: part || "", low: 3.5, font: part && part.length > 1 ? "9.5px system-ui, sans-serif" : "italic 10.5px Georgia, serif" }
      : { text: part, low: 0, font: m % 3 ? "italic 14px Georgia, serif" : "12.5px system-ui, sans-serif" });
    let wide = 0;
    for (const part of parts) { f.pen.font = part.font; part.at = wide; wide += f.pen.measureText(part.text).width; }
    const begin = align === "right" ? x - wide : align === "center" ? x - wide / 2 : x;
    f.pen.textAlign = "left";
    for (const part of parts) { f.pen.font = part.font; f.pen.fillText(part.text, begin + part.at, y + part.low); }
  };
  const ticks = (low, high, most) => {
    const rough = (high - low) / most, ten = 10 ** Math.floor(Math.log10(rough));
    const step = ten * ([1, 2, 5, 10].find((m) => m * ten >= rough) || 10), first = Math.ceil(low / step);
    const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
    return [...Array(Math.max(0, Math.floor(high / step + 1e-9) - first + 1)).keys()].map((k) => {
      const value = (first + k) * step;
      return [value, Math.abs(value) >= 1e5 || digits > 4 ? value.toPrecision(2) : value.toFixed(digits).replace("-", "−")];
    });
  };
  const labels = (f, across, up, numbered = true) => {
    f.pen.fillStyle = colour("soft");
    write(f, across, f.width - 6, f.height - 6, "right");
    write(f, up, 4, 13);
    if (!numbered) return;
    const value = (pixel, pixels) => (pixel - pixels(0)) / (pixels(1) - pixels(0));
    const [x, y] = [[value(f.left, f.px), value(f.width - 8, f.px)], [value(f.height - f.bottom, f.py), value(f.top, f.py)]];
    f.pen.strokeStyle = colour("rule");
    f.pen.lineWidth = 1;
    f.pen.beginPath();
    f.pen.moveTo(f.left, f.top);
    f.pen.lineTo(f.left, f.height - f.bottom);
    f.pen.lineTo(f.width - 8, f.height - f.bottom);
    for (const [v] of ticks(...x, 5)) { f.pen.moveTo(f.px(v), f.height - f.bottom); f.pen.lineTo(f.px(v), f.height - f.bottom + 4); }
    for (const [v] of ticks(...y, 5)) { f.pen.moveTo(f.left - 4, f.py(v)); f.pen.lineTo(f.left, f.py(v)); }
    f.pen.stroke();
    f.pen.font = "10.5px system-ui, sans-serif";
    f.pen.textAlign = "center";
    for (const [v, text] of ticks(...x, 5)) f.pen.fillText(text, f.px(v), f.height - f.bottom + 15);
    f.pen.textAlign = "right";
    for (const [v, text] of ticks(...y, 5)) f.pen.fillText(text, f.left - 6, f.py(v) + 3.5);
  };
  const well = (k) => {
    const { tape, sign, level } = data.wells[k], part = motion.parts[k], own = data.coordinates[k];
    const height = level === null ? 0 : sign * motion.inputs[level];
    let [low, high] = [-Math.PI, Math.PI];
    if (!own.direction) {
      const room = 0.3 * (part.b - part.a), [first, last] = data.wells[k].domain;
      low = Math.max(part.a - room, first ?? -Infinity);
      high = Math.min(part.b + room, last ?? Infinity);
    }
    const points = [...Array(221).keys()].map((m) => {
      const q = low + ((high - low) * (m + 0.5)) / 221, [F, A] = numbers.run(tape, [q, ...motion.inputs]);
      return [q, level === null ? -F / 2 : height - F / Math.abs(A), F, Math.abs(A)];
    });
    const inside = points.filter(([q]) => own.direction || (q >= part.a && q <= part.b)).map((p) => p[1]).filter(Number.isFinite);
    return { points, height, low, high, bottom: Math.min(height, ...inside), levels: level === null ? [] : neighbours(points, height, inside) };
  };
  // p(q) at other levels of the same potential, P² = F + |A| (level − height), and at the top of a barrier: the separatrix.
  const neighbours = (points, height, inside) => {
    const depth = height - Math.min(height, ...inside) || 1;
    const at = (h, top) => ({ top, up: points.flatMap(([q, , F, A], m) => {
      const square = F + A * (h - height), own = [q, Math.sqrt(square)], before = points[m - 1];
      const last = before && before[2] + before[3] * (h - height);
      const turning = before && square * last < 0 ? [[before[0] + ((q - before[0]) * last) / (last - square), 0]] : [];
      return [...turning, own];
    }) });
    const tops = points.slice(1, -1).map((p, m) => [points[m][1], p[1], points[m + 2][1]]).filter(([l, v, r]) => v > l && v >= r && v < height + 3 * depth);
    return [...[-0.75, -0.5, -0.25, 0.25, 0.5].map((part) => at(height + part * depth, false)), ...tops.map(([, v]) => at(v, true))];
  };
  const loop = (k) => {
    const own = data.coordinates[k], f = motion.parts[k].root;
    return [...Array(241).keys()].map((m) => {
      const chi = (m * Math.PI) / 120 - Math.PI;
      let root = 0;
      for (let w = 0; w < f.many; w++) root += f.c[w] * Math.cos(w * chi) + f.s[w] * Math.sin(w * chi);
      if (own.direction) return [own.direction * chi, own.direction * root];
      const { a, b } = motion.parts[k];
      return [(a + b) / 2 - ((b - a) / 2) * Math.cos(chi), ((b - a) / 2) * Math.sin(chi) * root];
    });
  };
  const sample = (m, fine) => {
    if (!samples.has(m)) samples.set(m, place(state(m / fine), m / fine));
    return samples.get(m);
  };
  const lengthen = () => {
    const mine = curves, stop = performance.now() + 6; // the rest of the path in the frames that follow
    while (mine.path.length <= mine.steps && (mine.path.length < 2 || performance.now() < stop)) mine.path.push(sample(mine.path.length, mine.fine));
    if (mine.path.length <= mine.steps) requestAnimationFrame(() => { if (curves === mine) { lengthen(); draw(); } });
  };
  const change = () => {
    motion = numbers.evaluate(settings);
    const cycles = many > 1 ? 14 : data.ignorable.length ? 6 : data.where.tape ? 1 : 2;
    const fine = (many > 1 ? 60 : 240) / shortest(), steps = Math.min(1600, Math.round(cycles * longest() * fine));
    samples = new Map();
    curves = { path: [], steps, span: steps / fine, fine, wells: data.coordinates.map((_, k) => well(k)), loops: data.coordinates.map((_, k) => loop(k)) };
    lengthen();
    at("numbers").innerHTML = "";
    const only = many === 1;
    const rows = data.sliders.map((s, i) => [s.label, settings[i]]);
    data.coordinates.forEach((own, k) => {
      const { a, b } = motion.parts[k];
      if (!own.direction) rows.push([`lower turning point of ${own.label}`, a], [`upper turning point of ${own.label}`, b]);
      rows.push([only ? "period" : `period of ${own.label}`, period(k)]);
    });
    data.ignorable.forEach((own, l) => rows.push(
      only ? [`gain of ${own.label} per period`, motion.drift[l] * period(0)] : [`mean velocity of ${own.label}`, motion.drift[l]]));
    if (!only) rows.push([`periods of ${data.coordinates[1].label} in one of ${data.coordinates[0].label}`, period(0) / period(1)]);
    for (const [name, value] of rows) {
      const row = at("numbers").insertRow();
      const head = document.createElement("th");
      head.scope = "row";
      name.split(NAME).forEach((part, m) => {
        const piece = m % 3 ? document.createElement(m % 3 === 1 ? "i" : "sub") : document.createTextNode(part);
        if (m % 3) piece.textContent = part || "";
        head.append(piece);
      });
      row.append(head);
      row.insertCell().textContent = shown(value, 7);
    }
    data.sliders.forEach((s, i) => {
      at(`value-${i}`).textContent = shown(settings[i], 5);
      at(`slider-${i}`).setAttribute("aria-valuetext", `${s.label} = ${settings[i].toPrecision(5)}`);
    });
    draw();
  };
  const drawWell = (k, s) => {
    const own = data.coordinates[k], { points, height, low, high, bottom } = curves.wells[k];
    const { a, b } = motion.parts[k], depth = height - bottom || 1, q = own.direction ? turn(s.q[own.name]) : s.q[own.name];
    const f = frame(at(`well-${k}`), range([low, high]), [bottom - 0.15 * depth, height + 0.6 * depth]);
    f.pen.save();
    f.pen.beginPath();
    f.pen.rect(f.left, f.top, f.width - f.left, f.height - f.top - f.bottom);
    f.pen.clip();
    line(f, points.map(([x, v]) => [x, v < height + 3 * depth ? v : NaN]), "ink", 1.6);
    line(f, own.direction ? [[low, height], [high, height]] : [[a, height], [b, height]], "red", 2);
    f.pen.restore();
    dot(f, q, height, "red", 5);
    labels(f, own.label, data.wells[k].title);
  };
  const drawPhase = (k, s) => {
    const own = data.coordinates[k], points = curves.loops[k], { low, high, levels } = curves.wells[k];
    const heights = points.map((p) => p[1]), reach = Math.max(...heights.map(Math.abs));
    const f = frame(at(`phase-${k}`), [low, high], own.direction ? range([0, ...heights]) : [-1.35 * reach, 1.35 * reach]);
    f.pen.save();
    f.pen.beginPath();
    f.pen.rect(f.left, f.top, f.width - f.left, f.height - f.top - f.bottom);
    f.pen.clip();
    for (const { up, top } of levels) for (const sign of [1, -1])
      line(f, up.map(([q, p]) => [q, sign * p]), top ? "ink" : "blue", top ? 1.2 : 0.7, top ? [5, 3] : []);
    f.pen.restore();
    line(f, points, "red", 1.6);
    dot(f, own.direction ? turn(s.q[own.name]) : s.q[own.name], s.p[own.name], "red", 5);
    labels(f, own.label, own.momentum);
  };
  const drawOrbit = (s) => {
    const loops = data.where.tape ? time : time % curves.span, now = project(place(s, loops));
    const flat = curves.path.map((p) => project(p)), { ball, centred, equal } = data.where;
    const span = ball ? [-1.08, 1.08] : null;
    const f = frame(at("orbit"), span || range(flat.map((p) => p[0]), centred), span || range(flat.map((p) => p[1]), centred), equal);
    const circle = [...Array(97).keys()].map((m) => [Math.cos((m * Math.PI) / 48), Math.sin((m * Math.PI) / 48)]);
    if (ball) line(f, circle, "rule", 1);
    line(f, flat, many > 1 ? "soft" : "red", many > 1 ? 0.5 : 1.2);
    if (many > 1) {
      const last = Math.floor(time * curves.fine), trail = [...Array(61).keys()].map((m) => last - 60 + m).filter((m) => m >= 0);
      line(f, [...trail.map((m) => project(sample(m, curves.fine))), now], "red", 2);
    }
    if (centred) dot(f, 0, 0, "ink", 3);
    dot(f, now[0], now[1], "red", 5);
    labels(f, data.where.axes[0], data.where.axes[1], !solid);
  };
  const draw = () => {
    const s = state(time);
    data.coordinates.forEach((_, k) => { drawWell(k, s); drawPhase(k, s); });
    drawOrbit(s);
    if (data.torus) torus();
    if (data.map) map();
    at("time").textContent = `${data.clock} = ${shown(time, 4)}`;
  };

  const torus = () => {
    const f = frame(at("torus"), [-1.5, 1.5], [-1.5, 1.5], true);
    const around = [...Array(61).keys()].map((k) => (k * Math.PI) / 30);
    for (let k = 0; k < 12; k++) {
      line(f, around.map((v) => project(ring((k * Math.PI) / 6, v), true)), "rule", 0.6);
      line(f, around.map((v) => project(ring(v, (k * Math.PI) / 6), true)), "rule", 0.6);
    }
    const T = period(0);
    const path = [...Array(601).keys()].map((k) => project(ring(...phases(time + (k / 60 - 10) * T)), true));
    line(f, path, "red", 1.2);
    dot(f, ...project(ring(...phases(time)), true), "red", 5);
    labels(f, "", `torus: ${data.torus.labels[0]} round the tube, ${data.torus.labels[1]} along`, false);
  };
  const map = () => {
    const [x, y] = data.map.window, [a, b] = data.map.sliders.map((i) => data.sliders[i]);
    const held = data.sliders.every((s, i) => data.map.sliders.includes(i) || Math.abs(settings[i] - s.value) <= (s.high - s.low) / 1000);
    const f = frame(at("map"), x, y);
    f.pen.save();
    f.pen.beginPath();
    f.pen.rect(f.left, f.top, f.width - f.left, f.height - f.top - f.bottom);
    f.pen.clip();
    if (held) for (const curve of data.map.curves) line(f, curve.map((p) => p || [NaN, NaN]), "ink", 1.6);
    if (held) for (const curve of data.map.ends) line(f, curve.map((p) => p || [NaN, NaN]), "soft", 0.7);
    if (held) for (const [u, v, letter] of data.map.letters) {
      f.pen.fillStyle = colour("soft");
      write(f, letter, f.px(u) + 8, f.py(v) + 4);
    }
    line(f, [[a.low, b.low], [a.high, b.low], [a.high, b.high], [a.low, b.high], [a.low, b.low]], "soft", 1, [3, 3]);
    f.pen.restore();
    dot(f, settings[data.map.sliders[0]], settings[data.map.sliders[1]], "red", 5);
    labels(f, a.label, held ? `${b.label}, map of all motions` : `${b.label}: the map holds for ${data.map.others}`);
    return f;
  };

  // ------------------------------------------------------------------ controls
  const step = (now) => {
    if (!playing) return;
    if (last !== null) time += ((now - last) / 1000) * speed * (longest() / 4);
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
  const rotate = (dx, dy) => {
    view = { azimuth: view.azimuth - dx / 120, elevation: Math.max(-1.5, Math.min(1.5, view.elevation + dy / 120)) };
    draw();
  };
  const arrows = (event, then) => {
    const move = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
    if (move) { event.preventDefault(); then(...move); }
  };
  for (const turning of [...(solid ? [orbit] : []), ...(data.torus ? [at("torus")] : [])]) {
    turning.addEventListener("pointermove", (event) => { if (event.buttons) rotate(event.movementX, event.movementY); });
    turning.addEventListener("keydown", (event) => arrows(event, (x, y) => rotate(12 * x, 12 * y)));
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
      const values = [...settings];
      values[data.map.sliders[0]] = x[0] + across * (x[1] - x[0]);
      values[data.map.sliders[1]] = y[0] + up * (y[1] - y[0]);
      choose(values);
    };
    at("map").addEventListener("pointerdown", clicked);
    at("map").addEventListener("pointermove", (event) => { if (event.buttons) clicked(event); });
    at("map").addEventListener("keydown", (event) => arrows(event, (x, y) =>
      choose(data.sliders.map((s, i) => {
        const move = i === data.map.sliders[0] ? x : i === data.map.sliders[1] ? -y : 0;
        return settings[i] + (move * (s.high - s.low)) / 100;
      }))));
  }
  // ------------------------------------------------------------------ the link: sliders and time after the # of the address
  const written = () => `#${[...data.sliders.map((s, i) => `${encodeURIComponent(s.name)}=${Number(settings[i].toPrecision(8))}`),
    `t=${Number(time.toPrecision(8))}`].join("&")}`;
  const restore = () => {
    const asked = new URLSearchParams(location.hash.slice(1));
    const number = (name) => (asked.has(name) && asked.get(name) !== "" && Number.isFinite(Number(asked.get(name))) ? Number(asked.get(name)) : null);
    if (!data.sliders.some((s) => asked.has(s.name)) && !asked.has("t")) return false;
    const outside = data.sliders.filter((s) => { const v = number(s.name); return v !== null && (v < s.low || v > s.high); });
    if (asked.has("t")) time = number("t") ?? time;
    choose(data.sliders.map((s, i) => number(s.name) ?? settings[i]));
    at("shared").textContent = outside.length
      ? `The link asks for ${outside.map((s) => `${s.label} = ${number(s.name)}`).join(", ")}, beyond the slider; its end is shown.` : "";
    return true;
  };
  at("share").addEventListener("click", async () => {
    const link = location.href.split("#")[0] + written();
    history.replaceState(null, "", link);
    try { await navigator.clipboard.writeText(link); at("shared").textContent = "Link copied."; }
    catch { at("shared").textContent = "The link is in the address bar."; }
  });
  window.addEventListener("hashchange", restore);
  window.addEventListener("resize", draw);
  window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
  window.hjsolveLive = {
    state, phases, settings, bounds: data.bounds, draw, rates: () => motion.rates, drift: () => motion.drift,
    ends: () => Object.fromEntries(data.coordinates.map((own, k) => [own.name, [motion.parts[k].a, motion.parts[k].b]])),
    set: (values) => { values.forEach((v, i) => { settings[i] = v; }); change(); }, seek: (t) => { time = t; draw(); },
  };
  root.hidden = false;
  if (!restore()) change();
})();
