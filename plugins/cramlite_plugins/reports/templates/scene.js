// A small renderer without any library and without WebGL: triangles with one light, a depth buffer, outlines.
// makeScene(canvas, data) answers { draw(tick), look(name) }. Lengths in metres, z is up. The data: scene_data.py.
function makeScene(canvas, data) {
  const LIGHT = unit([-0.45, -0.55, 0.85]), AMBIENT = 0.46, FILL = 0.14, NEAR = 0.05, FIELD = Math.tan(21 * Math.PI / 180);
  const FORCE = 0.01;  // length of the arrow [m/N]
  const far = Math.max(1.15 * data.size, 1);
  const LOOKS = {
    room: { yaw: -2.04, pitch: 0.45, distance: far, target: data.middle },
    front: { yaw: 0, pitch: 0.15, distance: far, target: data.middle },
    side: { yaw: -Math.PI / 2, pitch: 0.15, distance: far, target: data.middle },
    top: { yaw: -Math.PI / 2, pitch: 1.5, distance: far, target: data.middle },
    hand: { yaw: -2.3, pitch: 0.35, distance: 0.7, target: null },  // follows the tool
  };
  const pen = canvas.getContext("2d"), poses = unpack(data.poses), path = unpack(data.path), force = unpack(data.force);
  const solids = data.solids.map(s => ({ ...s, world: new Float32Array(s.vertices.length), placed: -1 }));
  let eye = { ...LOOKS.room }, tick = 0, image, depth, owner, waiting = false;

  function unpack(text) {
    const bytes = Uint8Array.from(atob(text), c => c.charCodeAt(0));
    return new Int16Array(bytes.buffer);
  }
  function unit(v) { const n = Math.hypot(...v) || 1; return v.map(x => x / n); }
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const toolAt = k => [0, 1, 2].map(i => path[3 * k + i] * data.unit);

  function poseOf(body) {
    const index = data.moving.indexOf(body);
    if (index < 0) return data.still[body];
    const from = 7 * (tick * data.moving.length + index);
    return [0, 1, 2, 3, 4, 5, 6].map(i => poses[from + i] * (i < 3 ? data.unit : data.turn));
  }
  function place(solid) {  // vertices to the world, once for those that stand still
    const moves = data.moving.includes(solid.body), stamp = moves ? tick : 0;
    if (solid.placed === stamp) return;
    solid.placed = stamp;
    const [px, py, pz, w, x, y, z] = poseOf(solid.body), v = solid.vertices, out = solid.world, s = data.fine;
    const r = [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y), 2 * (x * y + w * z), 1 - 2 * (x * x + z * z),
      2 * (y * z - w * x), 2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)];
    for (let i = 0; i < v.length; i += 3) {
      const a = v[i] * s, b = v[i + 1] * s, c = v[i + 2] * s;
      out[i] = px + r[0] * a + r[1] * b + r[2] * c;
      out[i + 1] = py + r[3] * a + r[4] * b + r[5] * c;
      out[i + 2] = pz + r[6] * a + r[7] * b + r[8] * c;
    }
  }
  function camera() {  // where it is, and its axes: right, up, forward
    const target = eye.target || toolAt(tick), c = Math.cos(eye.pitch);
    const back = [c * Math.cos(eye.yaw), c * Math.sin(eye.yaw), Math.sin(eye.pitch)];
    const at = target.map((t, i) => t + eye.distance * back[i]), forward = back.map(x => -x);
    const right = unit(cross(forward, [0, 0, 1]));
    return { at, right, up: cross(right, forward), forward };
  }
  function seen(view, x, y, z) {  // a point in the camera's axes
    const d = [x - view.at[0], y - view.at[1], z - view.at[2]];
    return [dot(d, view.right), dot(d, view.up), dot(d, view.forward)];
  }
  function clipped(corners) {  // the part of a triangle before the near plane
    const out = [];
    corners.forEach((a, i) => {
      const b = corners[(i + 1) % corners.length];
      if (a[2] > NEAR) out.push(a);
      if ((a[2] > NEAR) !== (b[2] > NEAR)) {
        const t = (NEAR - a[2]) / (b[2] - a[2]);
        out.push([a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]), NEAR]);
      }
    });
    return out;
  }
  function resize() {  // two pixels for each that is shown, within reason: smooth edges
    const width = Math.round(Math.min(2 * canvas.clientWidth, 1100)) || 400, height = Math.round(width * 0.75);
    if (image && canvas.width === width) return;
    Object.assign(canvas, { width, height });
    image = pen.createImageData(width, height);
    depth = new Float32Array(width * height);
    owner = new Uint16Array(width * height);
  }
  function colourOf(name) {
    const probe = getComputedStyle(canvas).getPropertyValue(name).trim();
    return [1, 3, 5].map(i => parseInt(probe.slice(i, i + 2), 16));
  }
  function clear(pixels, width, height) {
    const top = colourOf("--sky-top"), low = colourOf("--sky-low");
    for (let y = 0; y < height; y++) {
      const t = y / height, c = top.map((v, i) => v + t * (low[i] - v));
      pixels.fill(255 << 24 | c[2] << 16 | c[1] << 8 | c[0], y * width, (y + 1) * width);
    }
    depth.fill(0);
    owner.fill(0);
  }
  function fill(a, b, c, colour, number, pixels, width, height) {  // one triangle; depth is 1 / distance, so larger is nearer
    const area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    if (!area) return;
    const x0 = Math.max(0, Math.ceil(Math.min(a[0], b[0], c[0]))), x1 = Math.min(width - 1, Math.floor(Math.max(a[0], b[0], c[0])));
    const y0 = Math.max(0, Math.ceil(Math.min(a[1], b[1], c[1]))), y1 = Math.min(height - 1, Math.floor(Math.max(a[1], b[1], c[1])));
    const ux = (b[1] - c[1]) / area, uy = (c[0] - b[0]) / area, vx = (c[1] - a[1]) / area, vy = (a[0] - c[0]) / area;
    const zx = ux * a[2] + vx * b[2] - (ux + vx) * c[2];
    for (let y = y0; y <= y1; y++) {
      let u = ux * (x0 - c[0]) + uy * (y - c[1]), v = vx * (x0 - c[0]) + vy * (y - c[1]);
      let z = u * a[2] + v * b[2] + (1 - u - v) * c[2];
      for (let x = x0, p = y * width + x0; x <= x1; x++, p++, u += ux, v += vx, z += zx) {
        if (u >= 0 && v >= 0 && u + v <= 1 && z > depth[p]) { depth[p] = z; pixels[p] = colour; owner[p] = number; }
      }
    }
  }
  function shade(colour, normal, toEye) {
    const light = AMBIENT + FILL * Math.abs(dot(normal, toEye)) + (1 - AMBIENT - FILL) * Math.max(0, dot(normal, LIGHT));
    const [r, g, b] = colour.map(c => Math.min(255, 255 * Math.pow(c / 255 * light, 0.87)));
    return 255 << 24 | b << 16 | g << 8 | r;
  }
  function paint(solid, number, view, pixels, width, height) {
    const w = solid.world, scale = height / 2 / FIELD;
    for (let i = 0; i < solid.faces.length; i += 3) {
      const [p, q, r] = [0, 1, 2].map(k => { const j = 3 * solid.faces[i + k]; return [w[j], w[j + 1], w[j + 2]]; });
      const normal = unit(cross(q.map((x, k) => x - p[k]), r.map((x, k) => x - p[k])));
      const toEye = unit(view.at.map((x, k) => x - p[k]));
      if (dot(normal, toEye) <= 0) continue;
      const colour = shade(solid.colour, normal, toEye);
      const flat = clipped([p, q, r].map(v => seen(view, ...v))).map(v => [width / 2 + scale * v[0] / v[2], height / 2 - scale * v[1] / v[2], 1 / v[2]]);
      for (let k = 2; k < flat.length; k++) fill(flat[0], flat[k - 1], flat[k], colour, number, pixels, width, height);
    }
  }
  function outline(pixels, width, height) {  // darker where one solid ends
    for (let p = 0; p < width * (height - 1) - 1; p++) {
      if (owner[p] === owner[p + 1] && owner[p] === owner[p + width]) continue;
      const c = pixels[p];
      pixels[p] = 255 << 24 | ((c >> 16 & 255) * 0.62) << 16 | ((c >> 8 & 255) * 0.62) << 8 | (c & 255) * 0.62;
    }
  }
  function onScreen(view, point) {
    const [x, y, z] = seen(view, ...point), scale = canvas.height / 2 / FIELD;
    return z > NEAR ? [canvas.width / 2 + scale * x / z, canvas.height / 2 - scale * y / z] : null;
  }
  function trail(view) {  // the tool's path in the colours of the tasks, faint where it is still to come
    const style = getComputedStyle(canvas), points = data.colours.map((_, k) => onScreen(view, toolAt(k)));
    pen.lineCap = "round";
    for (let k = 1; k < points.length; k++) {
      if (!points[k - 1] || !points[k]) continue;
      pen.globalAlpha = k <= tick ? 0.9 : 0.22;
      pen.lineWidth = canvas.width / (k <= tick ? 260 : 420);
      pen.strokeStyle = style.getPropertyValue("--t" + data.colours[k]);
      pen.beginPath(); pen.moveTo(...points[k - 1]); pen.lineTo(...points[k]); pen.stroke();
    }
    pen.globalAlpha = 1;
  }
  function arrow(view) {  // what the tool presses with
    const f = [0, 1, 2].map(i => force[3 * tick + i] * 0.01);
    if (Math.hypot(...f) < 1) return;
    const at = toolAt(tick), from = onScreen(view, at), to = onScreen(view, at.map((x, i) => x + FORCE * f[i]));
    if (!from || !to) return;
    const turn = Math.atan2(to[1] - from[1], to[0] - from[0]), head = canvas.width / 60;
    pen.strokeStyle = pen.fillStyle = getComputedStyle(canvas).getPropertyValue("--force");
    pen.lineWidth = canvas.width / 180;
    pen.beginPath(); pen.moveTo(...from); pen.lineTo(...to); pen.stroke();
    pen.beginPath(); pen.moveTo(to[0] + head * Math.cos(turn), to[1] + head * Math.sin(turn));
    for (const side of [2.4, -2.4]) pen.lineTo(to[0] + head * Math.cos(turn + side), to[1] + head * Math.sin(turn + side));
    pen.fill();
  }
  function now() {
    waiting = false;
    resize();
    const { width, height } = canvas, pixels = new Uint32Array(image.data.buffer), view = camera();
    clear(pixels, width, height);
    solids.forEach((solid, k) => { place(solid); paint(solid, k + 1, view, pixels, width, height); });
    outline(pixels, width, height);
    pen.putImageData(image, 0, 0);
    trail(view);
    arrow(view);
  }
  function soon() { if (!waiting) { waiting = true; requestAnimationFrame(now); } }
  function move(yaw, pitch, zoom) {
    eye.yaw += yaw;
    eye.pitch = Math.max(-0.2, Math.min(1.5, eye.pitch + pitch));
    eye.distance = Math.max(0.25, Math.min(4, eye.distance * zoom));
    soon();
  }
  const KEYS = { ArrowLeft: [-0.12, 0, 1], ArrowRight: [0.12, 0, 1], ArrowUp: [0, 0.08, 1], ArrowDown: [0, -0.08, 1], "+": [0, 0, 0.87], "-": [0, 0, 1.15] };
  canvas.addEventListener("keydown", e => {
    if (!KEYS[e.key] || e.ctrlKey || e.metaKey) return;
    e.preventDefault(); e.stopPropagation();
    move(...KEYS[e.key]);
  });
  canvas.addEventListener("pointerdown", e => canvas.setPointerCapture(e.pointerId));
  canvas.addEventListener("pointermove", e => { if (e.buttons) move(-e.movementX / 160, e.movementY / 200, 1); });
  canvas.addEventListener("wheel", e => { if (!e.ctrlKey) return; e.preventDefault(); move(0, 0, Math.exp(e.deltaY / 300)); }, { passive: false });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", soon);
  new ResizeObserver(soon).observe(canvas);
  return {
    draw(k) { tick = k; soon(); },
    look(name) { eye = { ...LOOKS[name] }; soon(); },
    zoom(by) { move(0, 0, by); },
  };
}
