// The object in 3-D: its coloured triangles, its box, and the cell of a line.
'use strict';

class View3D {
  constructor(canvas) {
    this.canvas = canvas;
    this.renderer = new THREE.WebGLRenderer({canvas, antialias: true, alpha: true});
    this.renderer.setPixelRatio(Math.min(devicePixelRatio || 1, 2));
    this.scene = new THREE.Scene();
    this.camera = new THREE.PerspectiveCamera(35, 1, 0.01, 100);
    const lamp = new THREE.DirectionalLight(0xffffff, 0.45);
    lamp.position.set(0.4, 0.6, 1);
    this.camera.add(lamp, lamp.target);
    this.scene.add(this.camera, new THREE.AmbientLight(0xffffff, 0.6));
    this.material = new THREE.MeshLambertMaterial({vertexColors: THREE.VertexColors || true, side: THREE.DoubleSide});
    new ResizeObserver(() => this.resize()).observe(canvas.parentElement);
    matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => this.draw());
  }

  // Everything is drawn in a frame in which the box is around 0 and its half diagonal is 1. stand() has to follow.
  show(object, positions, indices) {
    for (const old of [this.mesh, this.box, this.cell]) if (old) this.scene.remove(old);
    if (this.mesh) this.mesh.geometry.dispose();
    this.cell = null;
    this.centre = object.box_min.map((low, a) => (low + object.box_max[a]) / 2);
    this.radius = Math.hypot(...object.box_min.map((low, a) => object.box_max[a] - low)) / 2;
    const corners = new Float32Array(3 * indices.length);
    for (let i = 0; i < indices.length; ++i)
      for (let a = 0; a < 3; ++a)
        corners[3 * i + a] = (positions[3 * indices[i] + a] - this.centre[a]) / this.radius;
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', new THREE.BufferAttribute(corners, 3));
    geometry.setAttribute('color', new THREE.BufferAttribute(new Float32Array(corners.length), 3));
    geometry.computeVertexNormals();
    this.mesh = new THREE.Mesh(geometry, this.material);
    const ends = [object.box_min, object.box_max].map(p => this.fromObject(p));
    this.box = new THREE.Box3Helper(new THREE.Box3(...ends), 0x888888);
    this.box.material.transparent = true;
    this.box.material.opacity = 0.55;
    this.scene.add(this.mesh, this.box);
    this.resize();
  }

  // Puts the eye where it begins; it turns around an axis of the object, 'y' or 'z'.
  stand(up) {
    const half = this.camera.fov * Math.PI / 360, narrow = Math.min(1, this.camera.aspect);
    const away = 1.08 / Math.sin(Math.atan(Math.tan(half) * narrow)), high = 0.35 * away;
    this.camera.up.set(0, up === 'y' ? 1 : 0, up === 'z' ? 1 : 0);
    this.camera.position.set(0.5 * away, up === 'y' ? high : -0.79 * away, up === 'y' ? 0.79 * away : high);
    if (this.controls) this.controls.dispose();
    this.controls = new THREE.OrbitControls(this.camera, this.canvas);  // takes the camera's `up` now only
    this.controls.screenSpacePanning = true;
    this.controls.minDistance = 0.05;
    this.controls.maxDistance = 4 * away;
    this.controls.addEventListener('change', () => this.draw());
    this.draw();
  }

  fromObject(p) { return new THREE.Vector3(...p.map((x, a) => (x - this.centre[a]) / this.radius)); }
  toObject(v) { return v.toArray().map((x, a) => x * this.radius + this.centre[a]); }

  // colours: sRGB, 3 numbers 0 … 1 a triangle.
  paint(colourOf) {
    const colours = this.mesh.geometry.attributes.color;
    for (let t = 0; t < colours.count / 3; ++t) {
      const [r, g, b] = colourOf(t);
      for (let k = 0; k < 3; ++k) colours.setXYZ(3 * t + k, r, g, b);
    }
    colours.needsUpdate = true;
    this.draw();
  }

  resize() {
    const {clientWidth: width, clientHeight: height} = this.canvas.parentElement;
    if (!width || !height) return;
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.draw();
  }

  draw() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => {
      this.waiting = false;
      this.renderer.render(this.scene, this.camera);
    });
  }

  // The line through a place of the window: {origin, direction} in the object's frame, and the triangle that it meets
  // first, -1: none; how many it meets.
  lineAt(x, y) {
    const area = this.canvas.getBoundingClientRect();
    const ray = new THREE.Raycaster();
    const place = {x: (x - area.left) / area.width * 2 - 1, y: 1 - (y - area.top) / area.height * 2};
    this.camera.updateMatrixWorld();
    ray.setFromCamera(place, this.camera);
    const hits = ray.intersectObject(this.mesh);
    const point = this.toObject(ray.ray.origin), direction = ray.ray.direction.toArray();
    return {point, direction, triangle: hits.length ? hits[0].faceIndex : -1, met: hits.length};
  }

  // The two squares of a cell, its shaft and its middle line; null: none. colour: a CSS one.
  showCell(cell, colour) {
    if (this.cell) this.scene.remove(this.cell);
    this.cell = null;
    if (cell) {
      const [low, high] = cell.squares.map(square => square.map(p => this.fromObject(p)));
      const edges = [];
      for (let i = 0; i < 4; ++i) {
        const next = (i + 1) % 4;
        edges.push(low[i], low[next], high[i], high[next], low[i], high[i]);
      }
      const lines = new THREE.LineSegments(new THREE.BufferGeometry().setFromPoints(edges),
                                           new THREE.LineBasicMaterial({color: colour}));
      const faces = new THREE.BufferGeometry().setFromPoints(
          [low, high].flatMap(s => [s[0], s[1], s[2], s[0], s[2], s[3]]));
      const glass = new THREE.Mesh(faces, new THREE.MeshBasicMaterial(
          {color: colour, side: THREE.DoubleSide, transparent: true, opacity: 0.45, depthWrite: false}));
      const middle = new THREE.Line(
          new THREE.BufferGeometry().setFromPoints(cell.ends.map(p => this.fromObject(p))),
          new THREE.LineBasicMaterial({color: colour, depthTest: false, transparent: true}));
      this.cell = new THREE.Group();
      this.cell.add(lines, glass, middle);
      this.scene.add(this.cell);
    }
    this.draw();
  }
}
