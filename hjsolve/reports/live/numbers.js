"use strict";
// The values of a live report: its tables at a setting of the sliders, phases and places at a time, formulas as tapes.
// The twin of page_numbers.py; what is computed beforehand is described in docs/live.md.
const hjsolveNumbers = (data) => {
  const bytes = Uint8Array.from(atob(data.table), (c) => c.charCodeAt(0));
  const table = new Float64Array(bytes.buffer), n = data.coordinates.length, WAVES = data.waves;

  // ------------------------------------------------------------------ formulas
  const unary = {
    neg: (x) => -x, sqrt: Math.sqrt, exp: Math.exp, log: Math.log, sin: Math.sin, cos: Math.cos, tan: Math.tan,
    asin: Math.asin, acos: Math.acos, atan: Math.atan, sinh: Math.sinh, cosh: Math.cosh, tanh: Math.tanh,
    sech: (x) => 1 / Math.cosh(x), asinh: Math.asinh, acosh: Math.acosh, atanh: Math.atanh, abs: Math.abs,
  };
  const run = (tape, inputs) => {
    const slots = inputs.slice();
    for (const [code, a, b] of tape.operations) {
      if (code === "add") slots.push(slots[a] + slots[b]);
      else if (code === "sub") slots.push(slots[a] - slots[b]);
      else if (code === "mul") slots.push(slots[a] * slots[b]);
      else if (code === "div") slots.push(slots[a] / slots[b]);
      else if (code === "power") slots.push(slots[a] ** b);
      else if (code === "rational") slots.push(a / b);
      else if (code === "pi") slots.push(Math.PI);
      else slots.push(unary[code](slots[a]));
    }
    return tape.outputs.map((slot) => slots[slot]);
  };

  // ------------------------------------------------------------------ series
  const waves = (x, many) => {
    const C = new Float64Array(many), S = new Float64Array(many), c = Math.cos(x), s = Math.sin(x);
    C[0] = 1;
    for (let k = 1; k < many; k++) { C[k] = C[k - 1] * c - S[k - 1] * s; S[k] = S[k - 1] * c + C[k - 1] * s; }
    return [C, S];
  };
  const value = (f, [C, S]) => {
    let sum = 0;
    for (let k = 0; k < f.many; k++) sum += f.c[k] * C[k] + f.s[k] * S[k];
    return sum;
  };
  const integral = (f, [C, S]) => {
    let sum = 0;
    for (let k = 1; k < f.many; k++) sum += (f.c[k] * S[k] + f.s[k] * (1 - C[k])) / k;
    return sum;
  };
  const series = () => ({ c: new Float64Array(WAVES), s: new Float64Array(WAVES), many: 1 });
  const solve = (A, b) => {
    const rows = A.map((row, k) => [...row, b[k]]), size = rows.length;
    for (let k = 0; k < size; k++) {
      const best = rows.slice(k).reduce((m, row, j) => (Math.abs(row[k]) > Math.abs(rows[m][k]) ? k + j : m), k);
      [rows[k], rows[best]] = [rows[best], rows[k]];
      for (let i = 0; i < size; i++) {
        if (i === k) continue;
        const share = rows[i][k] / rows[k][k];
        for (let j = k; j <= size; j++) rows[i][j] -= share * rows[k][j];
      }
    }
    return rows.map((row, k) => row[size] / row[k]);
  };

  // ------------------------------------------------------------------ the motion at a setting
  const evaluate = (values) => {
    const row = new Float64Array(data.columns);
    const T = data.sliders.map((s, i) => {
      const u = Math.max(-1, Math.min(1, (2 * values[i] - s.low - s.high) / (s.high - s.low))), found = [1, u];
      for (let k = 2; k < data.size; k++) found.push(2 * u * found[k - 1] - found[k - 2]);
      return found;
    });
    data.degrees.forEach((degrees, m) => {
      const factor = degrees.reduce((product, degree, i) => product * T[i][degree], 1);
      for (let k = 0; k < data.columns; k++) row[k] += factor * table[m * data.columns + k];
    });
    const parts = data.coordinates.map((own) => Object.fromEntries(Object.entries(own.parts).map(([group, { begin, ranks }]) => {
      if (group === "a" || group === "b") return [group, row[begin]];
      const f = series();
      ranks.forEach((rank, k) => {
        const wave = rank < WAVES ? rank : rank - WAVES + 1;
        (rank < WAVES ? f.c : f.s)[wave] = row[begin + k];
        f.many = Math.max(f.many, wave + 1);
      });
      return [group, f];
    })));
    const mean = (i, j) => (parts[i][j] ? parts[i][j].c[0] : 0);
    const all = [...Array(n).keys()], means = all.map((j) => all.map((i) => mean(i, j)));
    const columns = all.map((j) => solve(means, all.map((k) => Number(k === j))));
    const ripples = all.map((k) => all.map((i) => {
      const f = series();
      for (const j of all) {
        const part = parts[i][j];
        if (!part) continue;
        for (let m = 0; m < part.many; m++) { f.c[m] += columns[j][k] * part.c[m]; f.s[m] += columns[j][k] * part.s[m]; }
        f.many = Math.max(f.many, part.many);
      }
      f.c[0] = 0;
      return f;
    }));
    const rates = all.map((k) => columns[0][k]);
    const inputs = data.base.slice();
    data.moved.forEach((place, i) => { inputs[place] = values[i]; });
    const motion = { parts, ripples, rates, inputs, begin: all.map(() => 0) };
    const start = data.coordinates.map((c) => c.phase);
    motion.begin = start.map((x, k) => x + bent(motion, start.map((y) => waves(y, WAVES)))[k]);
    motion.drift = data.ignorable.map((_, l) => -all.reduce((sum, i) => sum + mean(i, n + l) * rates[i], 0));
    motion.gained = data.ignorable.map((_, l) => gain(motion, l, start));
    return motion;
  };
  const bent = (motion, W) => motion.ripples.map((row) => row.reduce((sum, f, i) => sum + integral(f, W[i]), 0));
  const gain = (motion, l, chi) => -data.coordinates.reduce((sum, _, i) => {
    const f = motion.parts[i][n + l];
    return f ? sum + f.c[0] * chi[i] + integral(f, waves(chi[i], f.many)) : sum;
  }, 0);

  // ------------------------------------------------------------------ phases: Newton's method, steps halved until they help
  const phases = (motion, t) => {
    const angle = motion.begin.map((x, k) => x + motion.rates[k] * t);
    const turns = angle.map((x) => 2 * Math.PI * Math.round(x / (2 * Math.PI)));
    const goal = angle.map((x, k) => x - turns[k]);
    const many = Math.max(...motion.ripples.flat().map((f) => f.many));
    const at = (chi) => {
      const W = chi.map((x) => waves(x, many)), sum = bent(motion, W);
      const miss = chi.map((x, k) => x + sum[k] - goal[k]);
      return { W, miss, size: Math.max(...miss.map(Math.abs)) };
    };
    let chi = goal.slice(), now = at(chi);
    for (let turn = 0; turn < 60 && now.size > 0; turn++) {
      const A = motion.ripples.map((row, k) => row.map((f, i) => Number(k === i) + value(f, now.W[i])));
      const step = solve(A, now.miss);
      let share = 1, next, there;
      for (let half = 0; half < 12; half++, share /= 2) {
        next = chi.map((x, k) => x - share * step[k]);
        there = at(next);
        if (there.size <= (1 - share / 4) * now.size || now.size < 1e-13) break;
      }
      chi = next;
      now = there;
      if (Math.max(...step.map(Math.abs)) < 1e-14 || now.size < 1e-15) break;
    }
    return chi.map((x, k) => x + turns[k]);
  };
  const state = (motion, t) => {
    const chi = phases(motion, t), q = {}, p = {};
    data.coordinates.forEach((own, i) => {
      const part = motion.parts[i], root = value(part.root, waves(chi[i], part.root.many));
      if (own.direction) {
        q[own.name] = own.direction * chi[i];
        p[own.name] = own.direction * root;
      } else {
        const half = (part.b - part.a) / 2;
        q[own.name] = (part.a + part.b) / 2 - half * Math.cos(chi[i]);
        p[own.name] = half * Math.sin(chi[i]) * root;
      }
    });
    data.ignorable.forEach((own, l) => {
      q[own.name] = own.begin + gain(motion, l, chi) - motion.gained[l];
      p[own.name] = motion.inputs[n + l];
    });
    return { q, p };
  };
  return { evaluate, phases, state, run };
};
