"use strict";
(() => {
  // Colors are mixed and shown as they are written.
  THREE.ColorManagement.enabled = false;

  const { files, surfaces, rows } = JSON.parse(document.getElementById("data").textContent);
  const byId = (id) => document.getElementById(id);

  // Lightness falls evenly from 0 to the greatest distance, so gray prints can be read too.
  const RAMP = ["#f6f2d2", "#c5dd8c", "#79c58c", "#2fa59a", "#2480a0", "#35579a", "#4a2a80"];
  const PLAIN = "#e9e3d8";
  const SIZE = 100; // The model's diagonal as drawn; it suits the thresholds of the controls.
  const WIDTH = 2048; // Of textures that hold one number per texel.
  const HOME = { theta: 0.62, phi: 1.2 };
  const MARGIN = 1.1; // Around the model in the first view.
  const UPRIGHT = 0.03; // The eye stays at least so far from the axis; radians.

  // ---- Unpack: arrays are deflated, in base64, one element each ----

  async function unpack(id, Type) {
    const text = atob(byId("blob-" + id).textContent);
    const packed = new Uint8Array(text.length);
    for (let i = 0; i < text.length; i++) packed[i] = text.charCodeAt(i);
    const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
    return new Type(await new Response(stream).arrayBuffer());
  }

  async function loadSurface({ points, faces, steps }) {
    return {
      points: await unpack(points, Float32Array),
      faces: await unpack(faces, Uint32Array),
      steps: await unpack(steps, Uint8Array),
    };
  }

  // ---- One surface: triangles with corners of their own, and a texture of distances ----

  const countLattice = (k) => ((k + 1) * (k + 2)) / 2;

  function buildGeometry({ points, faces, steps }) {
    const position = new Float32Array(faces.length * 3);
    const cut = new Float32Array(faces.length * 2); // Per corner: first texel of its face, steps a side.
    let texel = 0;
    for (let i = 0; i < faces.length; i++) {
      const k = steps[(i / 3) | 0];
      for (let axis = 0; axis < 3; axis++) position[3 * i + axis] = points[3 * faces[i] + axis];
      cut[2 * i] = texel;
      cut[2 * i + 1] = k;
      if (i % 3 === 2) texel += countLattice(k);
    }
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(position, 3));
    geometry.setAttribute("cut", new THREE.BufferAttribute(cut, 2));
    return geometry;
  }

  // Sixteen-bit distances of the points, then of the lattices of faces that are cut, as shares of `top`.
  function buildTexture({ points, faces, steps }, distances, top) {
    const total = steps.reduce((sum, k) => sum + countLattice(k), 0);
    const texels = new Float32Array(WIDTH * Math.max(1, Math.ceil(total / WIDTH)));
    let texel = 0;
    let next = points.length / 3;
    for (let face = 0; face < steps.length; face++) {
      if (steps[face] === 1) {
        for (let i = 0; i < 3; i++) texels[texel++] = distances[faces[3 * face + i]];
      } else {
        for (let left = countLattice(steps[face]); left > 0; left--) texels[texel++] = distances[next++];
      }
    }
    for (let i = 0; i < texel; i++) texels[i] *= top / 65535;
    const texture = new THREE.DataTexture(texels, WIDTH, texels.length / WIDTH, THREE.RedFormat, THREE.FloatType);
    texture.needsUpdate = true;
    return texture;
  }

  const VERTEX = `
    in vec2 cut;
    out vec3 share;
    out vec3 seen;
    flat out ivec2 lattice;
    void main() {
      int corner = gl_VertexID % 3;
      share = vec3(corner == 0, corner == 1, corner == 2);
      lattice = ivec2(cut);
      vec4 placed = modelViewMatrix * vec4(position, 1.0);
      seen = placed.xyz;
      gl_Position = projectionMatrix * placed;
    }`;

  const FRAGMENT = `
    precision highp float;
    precision highp int;
    uniform highp sampler2D distances;
    uniform vec3 ramp[${RAMP.length}];
    uniform vec3 plain;
    uniform float top, line;
    uniform bool edges, colored;
    in vec3 share;
    in vec3 seen;
    flat in ivec2 lattice;
    out vec4 color;

    float at(int i, int j) {
      int texel = lattice.x + j * (lattice.y + 1) - j * (j - 1) / 2 + i;
      return texelFetch(distances, ivec2(texel % ${WIDTH}, texel / ${WIDTH}), 0).r;
    }

    float distanceHere() {
      int k = lattice.y;
      vec2 place = clamp(share.yz, 0.0, 1.0) * float(k);
      int j = min(int(place.y), k - 1);
      int i = min(int(place.x), k - 1 - j);
      vec2 f = clamp(place - vec2(i, j), 0.0, 1.0);
      if (f.x + f.y <= 1.0 || i + j == k - 1)
        return at(i, j) * max(1.0 - f.x - f.y, 0.0) + at(i + 1, j) * f.x + at(i, j + 1) * f.y;
      return at(i + 1, j + 1) * (f.x + f.y - 1.0) + at(i, j + 1) * (1.0 - f.x) + at(i + 1, j) * (1.0 - f.y);
    }

    vec3 rampAt(float t) {
      float place = clamp(t, 0.0, 1.0) * ${RAMP.length - 1}.0;
      int i = min(int(place), ${RAMP.length - 2});
      return mix(ramp[i], ramp[i + 1], place - float(i));
    }

    void main() {
      vec3 normal = normalize(cross(dFdx(seen), dFdy(seen)));
      normal *= sign(-dot(normal, seen));
      vec3 up = normalize((viewMatrix * vec4(0.0, 1.0, 0.0, 0.0)).xyz);
      float light = 0.72 + 0.24 * max(dot(normal, normalize(vec3(-0.5, 0.35, 0.8))), 0.0) + 0.09 * dot(normal, up);
      vec3 base = colored ? rampAt(distanceHere() / top) : plain;
      vec3 width = max(fwidth(share), vec3(1e-6));
      vec3 away = share / width;
      float drawn = 1.0 - smoothstep(line - 0.5, line + 0.5, min(away.x, min(away.y, away.z)));
      // Where triangles are hardly larger than lines, lines would hide them.
      float room = 1.0 / max(width.x, max(width.y, width.z));
      float strength = edges ? drawn * mix(0.12, 0.62, smoothstep(2.0 * line, 12.0 * line, room)) : 0.0;
      color = vec4(mix(base * light, vec3(0.09, 0.14, 0.22), strength), 1.0);
    }`;

  // ---- Two views, one camera ----

  const camera = new THREE.PerspectiveCamera(28, 1, 1, 1000);
  const target = new THREE.Vector3();
  const shared = {
    ramp: { value: RAMP.map((each) => new THREE.Color(each)) },
    plain: { value: new THREE.Color(PLAIN) },
    top: { value: 1 },
    line: { value: 0.5 },
    edges: { value: true },
    colored: { value: true },
  };
  let stale = true; // Whether something has changed since the last frame.

  class View {
    constructor(figure) {
      this.figure = figure;
      this.stage = figure.querySelector(".stage");
      const name = figure.id === "left" ? "Original" : "Result";
      const canvas = document.createElement("canvas");
      canvas.tabIndex = 0;
      canvas.setAttribute("role", "img");
      canvas.setAttribute("aria-label", name + " in 3D; arrow keys turn it, + and - zoom, 0 resets");
      this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true, alpha: true });
      this.stage.prepend(canvas);
      this.scene = new THREE.Scene();
      this.model = new THREE.Group();
      this.scene.add(this.model);
      this.controls = new THREE.TrackballControls(camera, canvas);
      Object.assign(this.controls, { target, staticMoving: true, rotateSpeed: 2.2, panSpeed: 0.5, keys: [] });
      canvas.addEventListener("keydown", onKey);
      new ResizeObserver(() => this.resize()).observe(this.stage);
    }

    resize() {
      const { clientWidth: width, clientHeight: height } = this.stage;
      this.renderer.setPixelRatio(window.devicePixelRatio);
      this.renderer.setSize(width, height, false);
      this.controls.handleResize();
      this.aspect = width / height;
      shared.line.value = 0.5 * Math.max(window.devicePixelRatio, 1);
      stale = true;
    }

    show(surface, distances, top, file) {
      this.model.clear();
      if (this.dispose) this.dispose();
      const geometry = buildGeometry(surface);
      const texture = buildTexture(surface, distances, top);
      const material = new THREE.ShaderMaterial({
        glslVersion: THREE.GLSL3,
        vertexShader: VERTEX,
        fragmentShader: FRAGMENT,
        side: THREE.DoubleSide,
        uniforms: { ...shared, distances: { value: texture } },
      });
      const mesh = new THREE.Mesh(geometry, material);
      mesh.frustumCulled = false;
      this.model.add(mesh);
      this.model.scale.setScalar(SIZE / (file.diagonal || 1));
      this.dispose = () => [geometry, texture, material].forEach((each) => each.dispose());
    }

    describe(lines) {
      this.figure.querySelectorAll("figcaption > *").forEach((each, i) => { each.textContent = lines[i]; });
    }
  }

  const views = [];
  let eye = new THREE.Spherical(); // Of the camera about the target.

  // Keep the horizon level: the trackball may neither roll nor go over the top.
  function level() {
    const next = new THREE.Spherical().setFromVector3(camera.position.clone().sub(target));
    const swing = Math.abs(Math.atan2(Math.sin(next.theta - eye.theta), Math.cos(next.theta - eye.theta)));
    if (swing > Math.PI / 2) Object.assign(next, { theta: eye.theta, phi: eye.phi < Math.PI / 2 ? 0 : Math.PI });
    place(next);
  }

  function place(next) {
    next.phi = Math.min(Math.max(next.phi, UPRIGHT), Math.PI - UPRIGHT);
    next.radius = Math.min(Math.max(next.radius, SIZE / 500), SIZE * 20);
    eye = next;
    camera.position.setFromSpherical(eye).add(target);
    camera.up.set(0, 1, 0);
    camera.lookAt(target);
    const away = camera.position.length();
    camera.near = Math.max(away - 0.55 * SIZE, eye.radius / 50);
    camera.far = away + 0.55 * SIZE;
    stale = true;
  }

  function orient() {
    const upright = byId("up").value === "z" ? -Math.PI / 2 : 0;
    for (const view of views) view.model.rotation.x = upright;
    stale = true;
  }

  // Show the whole original, as large as it fits, in the middle.
  function reset() {
    if (!chosen) return;
    const { points } = loaded.get(files[chosen.file].original);
    const toWorld = views[0].model;
    toWorld.updateMatrixWorld();
    const slope = Math.tan((camera.fov * Math.PI) / 360);
    target.set(0, 0, 0);
    place(new THREE.Spherical(SIZE, HOME.phi, HOME.theta));
    for (let round = 0; round < 4; round++) {
      camera.updateMatrixWorld();
      const toCamera = camera.matrixWorldInverse.clone().multiply(toWorld.matrixWorld);
      const seen = new THREE.Vector3();
      const flat = new THREE.Vector2();
      const low = new THREE.Vector2(Infinity, Infinity);
      const high = new THREE.Vector2(-Infinity, -Infinity);
      let nearest = -Infinity;
      for (let i = 0; i < points.length; i += 3) {
        seen.fromArray(points, i).applyMatrix4(toCamera);
        low.min(flat.set(seen.x / -seen.z, seen.y / -seen.z));
        high.max(flat);
        nearest = Math.max(nearest, seen.z);
      }
      const across = Math.max((high.x - low.x) / views[0].aspect, high.y - low.y) / 2;
      const aside = new THREE.Vector3((low.x + high.x) / 2, (low.y + high.y) / 2, 0);
      target.add(aside.multiplyScalar(eye.radius).applyQuaternion(camera.quaternion));
      const radius = eye.radius + nearest + (-nearest * across * MARGIN) / slope;
      place(new THREE.Spherical(radius, HOME.phi, HOME.theta));
    }
  }

  function onKey(event) {
    const step = 0.08;
    const next = eye.clone();
    if (event.key === "ArrowLeft") next.theta -= step;
    else if (event.key === "ArrowRight") next.theta += step;
    else if (event.key === "ArrowUp") next.phi -= step;
    else if (event.key === "ArrowDown") next.phi += step;
    else if (event.key === "+" || event.key === "=") next.radius /= 1.1;
    else if (event.key === "-") next.radius *= 1.1;
    else if (event.key === "0") return reset();
    else return;
    event.preventDefault();
    place(next);
  }

  function frame() {
    requestAnimationFrame(frame);
    const before = camera.position.clone();
    const aim = target.clone();
    for (const view of views) view.controls.update();
    if (!before.equals(camera.position) || !aim.equals(target)) level();
    if (!stale) return;
    stale = false;
    for (const view of views) {
      camera.aspect = view.aspect;
      camera.updateProjectionMatrix();
      view.renderer.render(view.scene, camera);
    }
  }

  // ---- The chosen row ----

  let chosen = null;
  let loaded = new Map(); // Surfaces of the chosen row, by number.
  let turn = 0;

  async function choose(id) {
    const own = ++turn;
    const row = rows[id];
    const file = files[row.file];
    for (const marked of document.querySelectorAll("[aria-current]")) marked.removeAttribute("aria-current");
    for (const mark of document.querySelectorAll(`[data-row="${id}"]`)) mark.setAttribute("aria-current", "true");
    document.querySelector(`tr[data-row="${id}"] input`).checked = true;
    for (const chart of document.querySelectorAll(".chart")) chart.hidden = chart.dataset.file !== String(row.file);

    const wanted = [file.original, row.surface];
    const now = new Map();
    for (const each of wanted) now.set(each, loaded.get(each) || (await loadSurface(surfaces[each])));
    const distances = [];
    for (const side of row.distances) distances.push(await unpack(side.blob, Uint16Array));
    if (own !== turn) return; // Another row was chosen meanwhile.

    const other = !chosen || chosen.file !== row.file;
    loaded = now;
    chosen = row;
    if (other) byId("up").value = file.up;
    views.forEach((view, i) => {
      view.show(now.get(wanted[i]), distances[i], row.distances[i].top, file);
      view.describe(i ? row.caption : file.caption);
    });
    sayAll("");
    orient();
    if (other) reset();
    rescale();
    document.body.dataset.shown = id;
  }

  function format(value) {
    const text = Number(value.toPrecision(3));
    return value > 0 && value < 1e-3 ? text.toExponential() : String(text);
  }

  function rescale() {
    if (!chosen) return;
    const tolerance = byId("top").querySelector("[value=tolerance]");
    tolerance.disabled = !(chosen.tolerance > 0);
    if (tolerance.disabled) byId("top").value = "own";
    const most = Math.max(chosen.deviation, ...chosen.distances.map((side) => side.top));
    const top = tolerance.selected ? chosen.tolerance : most;
    shared.top.value = top || 1;
    const ticks = top > 0 ? [0, 0.25, 0.5, 0.75, 1].map((part) => format(part * top)) : ["0 everywhere"];
    if (most > top) ticks[4] = "≥ " + ticks[4];
    byId("scale").querySelector(".ticks").replaceChildren(
      ...ticks.map((text) => Object.assign(document.createElement("span"), { textContent: text })),
    );
    stale = true;
  }

  function listen() {
    byId("scale").querySelector(".bar").style.backgroundImage = `linear-gradient(90deg, ${RAMP.join(", ")})`;
    const tick = (id, set) => byId(id).addEventListener("change", () => { set(byId(id).checked); stale = true; });
    tick("edges", (on) => { shared.edges.value = on; });
    tick("colors", (on) => { shared.colored.value = on; byId("scale").style.visibility = on ? "" : "hidden"; });
    byId("top").addEventListener("change", rescale);
    byId("up").addEventListener("change", () => { orient(); reset(); });
    byId("reset").addEventListener("click", reset);
    for (const row of document.querySelectorAll("[data-row]")) {
      row.addEventListener("click", (event) => { if (event.target.tagName !== "INPUT") pick(row.dataset.row); });
    }
    for (const input of document.querySelectorAll("tr[data-row] input")) {
      input.addEventListener("change", () => pick(input.closest("tr").dataset.row));
    }
  }

  const sayAll = (text) => document.querySelectorAll(".stage p").forEach((each) => { each.textContent = text; });
  const pick = (id) => choose(id).catch((error) => { sayAll("This row cannot be drawn: " + error.message); throw error; });

  const first = document.querySelector("tr[data-row][data-first]") || document.querySelector("tr[data-row]");
  if (!first) {
    sayAll("There is nothing to draw.");
    return;
  }
  if (!document.createElement("canvas").getContext("webgl2") || !window.DecompressionStream) {
    sayAll("This browser cannot draw in 3D: it needs WebGL 2 and a version of 2023 or later. Table and chart are below.");
    return;
  }
  views.push(new View(byId("left")), new View(byId("right")));
  views.forEach((view) => view.resize());
  listen();
  pick(first.dataset.row);
  frame();
})();
