// The tank in three dimensions: magnet and device turn, both paths, axes and arrows; played, scrubbed and followed.
import { CSS2DObject, CSS2DRenderer, OrbitControls, THREE } from "nicegui-scene";
import { clock } from "helimag-studio/clock.js";
import { place, runs, scalar, vector } from "helimag-studio/runs.js";
import { colour, on_theme, written } from "helimag-studio/ticks.js";

const SHARE = 0.18; // of the scene's size: the device is enlarged to about this
const FASTEST = 1.2; // turns a second that the eye can follow; what turns faster is shown slowed
const SLOWED = 0.5; // turns a second of what is shown slowed
const SPEEDS = [1, 10, 60, 300];

// whether there is no graphics card: then smooth edges would cost more than they show
function drawn_by_processor() {
  const context = document.createElement("canvas").getContext("webgl2");
  const about = context && context.getExtension("WEBGL_debug_renderer_info");
  const name = about ? context.getParameter(about.UNMASKED_RENDERER_WEBGL) : "";
  context?.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|software/i.test(name);
}

const as_vector = ([x, y, z]) => new THREE.Vector3(x, y, z);

export default {
  template: `
    <div class="hs-scene">
      <div ref="stage" class="hs-canvas" data-testid="scene">
        <div class="hs-note hs-note-left"><b>{{ told.time }}</b><br>{{ told.height }}<br>{{ told.gap }}</div>
        <div class="hs-note hs-note-right"><span v-for="line in told.remarks">{{ line }}<br></span></div>
        <div class="hs-note hs-note-foot">
          <span class="hs-key hs-key-blue">device's path</span><span class="hs-key hs-key-grey">magnet's path</span>
          <span class="hs-key hs-key-green">axis the field turns about</span><span class="hs-key hs-key-purple">thrust</span>
        </div>
      </div>
      <div class="hs-transport">
        <button class="hs-round" @click="play" :aria-label="playing ? 'Pause' : 'Play'" data-testid="play">
          <i class="material-icons">{{ playing ? 'pause' : 'play_arrow' }}</i></button>
        <input type="range" min="0" max="1000" step="1" :value="share" @input="scrub" aria-label="Time" data-testid="scrub">
        <select @change="clock.speed = +$event.target.value" aria-label="Speed" title="Seconds of the run in a second">
          <option v-for="speed in speeds" :value="speed" :selected="speed === 60">{{ speed }} ×</option></select>
        <button class="hs-pill" :class="{on: follow}" @click="follow = !follow; framed = false" title="Look at the device from near">
          Follow</button>
        <button class="hs-pill" :class="{on: true_size}" @click="true_size = !true_size; rebuild()"
          title="Draw the device in its own size, or enlarged so that it can be seen">True size</button>
      </div>
    </div>`,
  data: () => ({
    playing: false,
    share: 1000,
    follow: false,
    true_size: false,
    told: { time: "", height: "", gap: "", remarks: [] },
    speeds: SPEEDS,
  }),
  created() {
    this.clock = clock;
  },
  mounted() {
    this.set_up();
    this.quit = [runs.listen(() => this.rebuild()), clock.listen(() => this.frame()), on_theme(() => this.rebuild())];
    this.observer = new ResizeObserver(() => this.resize());
    this.observer.observe(this.$refs.stage);
    if (runs.live) this.rebuild();
  },
  unmounted() {
    this.quit.forEach((stop) => stop());
    this.observer.disconnect();
    this.clear();
    this.materials.forEach((material) => material.dispose());
    this.renderer.dispose();
  },
  methods: {
    set_up() {
      THREE.Object3D.DEFAULT_UP.set(0, 0, 1);
      const stage = this.$refs.stage;
      this.scene = new THREE.Scene();
      this.camera = new THREE.PerspectiveCamera(35, 1, 1, 20000);
      this.materials = new Map();
      this.renderer = new THREE.WebGLRenderer({ antialias: !drawn_by_processor(), alpha: true });
      this.renderer.setPixelRatio(Math.min(2, window.devicePixelRatio || 1));
      stage.prepend(this.renderer.domElement);
      this.labels = new CSS2DRenderer();
      this.labels.domElement.className = "hs-labels";
      stage.append(this.labels.domElement);
      this.controls = new OrbitControls(this.camera, this.renderer.domElement);
      this.controls.enableDamping = false;
      this.controls.addEventListener("change", () => (this.dirty = true));
      this.scene.add(new THREE.HemisphereLight(0xffffff, 0x889099, 2.2));
      const sun = new THREE.DirectionalLight(0xffffff, 1.8);
      sun.position.set(-200, -400, 700);
      this.scene.add(sun);
      this.group = new THREE.Group();
      this.scene.add(this.group);
    },
    resize() {
      const { clientWidth: width, clientHeight: height } = this.$refs.stage;
      if (!width || !height) return;
      this.renderer.setSize(width, height);
      this.labels.setSize(width, height);
      this.camera.aspect = width / height;
      this.camera.updateProjectionMatrix();
      this.dirty = true;
    },
    // materials stay: a new one would have its shader compiled anew
    clear() {
      this.group.traverse((object) => {
        object.geometry?.dispose();
        if (object.isCSS2DObject) object.element.remove();
      });
      this.group.clear();
    },
    material(kind, name, more = {}) {
      const shade = colour(name);
      const key = [kind, shade, JSON.stringify(more)].join();
      if (!this.materials.has(key)) this.materials.set(key, new THREE[kind]({ color: shade, ...more }));
      return this.materials.get(key);
    },
    rebuild() {
      const run = runs.live;
      if (!run) return;
      this.clear();
      this.extent = this.extent_of(run);
      const size = this.extent.size;
      this.enlarged = this.true_size ? 1 : Math.max(1, Math.round((SHARE * size) / run.device.length));
      this.tank(run, size);
      this.bodies(run);
      this.past = this.line(run.position, "blue", 1);
      this.group.add(this.past, this.line(run.position, "blue", 0.25), this.line(run.magnet, "grey", 0.7));
      runs.others.forEach((other, i) => this.group.add(this.dashed(other.position, "other" + (i % 3), 0.012 * size)));
      this.axis = this.arrow("green", 0.2 * size);
      this.thrust = this.arrow("purple", 0.3 * size);
      this.group.add(this.axis, this.thrust);
      this.frames(size);
      if (!this.framed || this.title !== run.title.split(",")[0]) this.look(run);
      this.title = run.title.split(",")[0];
      this.framed = true;
      this.dirty = true;
    },
    // device and magnet are built anew only where they are others
    bodies(run) {
      const key = JSON.stringify([run.device, run.magnets, colour("copper")]);
      if (key !== this.built) {
        for (const body of [this.device, this.magnet]) {
          body?.traverse((object) => object.geometry?.dispose());
          body?.removeFromParent();
        }
        this.device = this.device_of(run.device);
        this.magnet = this.magnet_of(run.magnets);
        this.scene.add(this.device, this.magnet);
        this.built = key;
      }
      this.device.scale.setScalar(this.enlarged);
    },
    // corners of all that is drawn
    extent_of(run) {
      const box = new THREE.Box3();
      for (const values of [run.position, run.magnet])
        for (let i = 0; i < values.length; i += 3) box.expandByPoint(new THREE.Vector3(values[i], values[i + 1], values[i + 2]));
      const reach = Math.max(...run.magnets.map((m) => Math.hypot(m.radius, m.height / 2)));
      box.expandByScalar(reach);
      const size = box.getSize(new THREE.Vector3());
      return { box, centre: box.getCenter(new THREE.Vector3()), size: Math.max(size.x, size.y, size.z) };
    },
    look(run) {
      const { centre, size } = this.extent;
      if (this.follow) {
        const at = as_vector(vector(run.position, place(run.time, clock.time)));
        this.camera.position.set(at.x + 40, at.y - 75, at.z + 22);
        this.controls.target.copy(at);
      } else {
        this.camera.position.set(centre.x + 0.85 * size, centre.y - 1.75 * size, centre.z + 0.45 * size);
        this.controls.target.copy(centre);
      }
      this.controls.update();
    },
    tank(run, size) {
      const { box } = this.extent;
      const [low, high] = run.box;
      const bottom = low[2] ?? box.min.z;
      const half = Math.ceil((0.62 * size) / 20) * 20;
      const grid = new THREE.GridHelper(2 * half, half / 10, colour("line"), colour("line"));
      grid.rotation.x = Math.PI / 2;
      grid.position.set(this.extent.centre.x, this.extent.centre.y, bottom);
      grid.material.dispose();
      grid.material = this.material("LineBasicMaterial", "line", { transparent: true, opacity: 0.55 });
      this.group.add(grid);
      this.group.add(this.label(low[2] === null ? "open water, 20 mm grid" : "floor, 20 mm grid", [grid.position.x - half, grid.position.y - half, bottom], "hs-3d hs-quiet"));
      if (high[2] !== null) this.sheet(this.across(low, high, grid.position, half), high[2], "surface");
      this.walls(low, high, bottom, high[2] ?? box.max.z);
    },
    // ends of a level sheet: the walls, or as far as the grid goes
    across(low, high, middle, half) {
      const end = (side, axis, sign) => side[axis] ?? middle.getComponent(axis) + sign * half;
      return [0, 1].map((axis) => [end(low, axis, -1), end(high, axis, 1)]);
    },
    sheet([[left, right], [front, back]], level, words) {
      const more = { transparent: true, opacity: 0.16, side: THREE.DoubleSide, depthWrite: false };
      const material = this.material("MeshBasicMaterial", "sky", more);
      const sheet = new THREE.Mesh(new THREE.PlaneGeometry(right - left, back - front), material);
      sheet.position.set((left + right) / 2, (front + back) / 2, level);
      this.group.add(sheet, this.label(words, [left, front, level], "hs-3d hs-quiet"));
    },
    walls(low, high, bottom, top) {
      for (const [axis, side] of [[0, low], [0, high], [1, low], [1, high]]) {
        if (side[axis] === null) continue;
        const other = 1 - axis;
        const [a, b] = [low[other] ?? this.extent.box.min.getComponent(other), high[other] ?? this.extent.box.max.getComponent(other)];
        const corner = (u, z) => (axis === 0 ? [side[0], u, z] : [u, side[1], z]);
        const points = [corner(a, bottom), corner(b, bottom), corner(b, top), corner(a, top), corner(a, bottom)];
        this.group.add(this.line(points.flat(), "muted", 0.7));
      }
    },
    device_of(shape) {
      const device = new THREE.Group();
      if (shape.wire.length) {
        const curve = new THREE.CatmullRomCurve3(shape.wire.map(as_vector));
        device.add(new THREE.Mesh(new THREE.TubeGeometry(curve, 2 * shape.wire.length, shape.wire_radius, 8), this.material("MeshLambertMaterial", "copper")));
      }
      if (shape.profile.length) {
        const lathe = new THREE.LatheGeometry(shape.profile.map(([x, r]) => new THREE.Vector2(r, x)), 28);
        lathe.rotateZ(-Math.PI / 2);
        device.add(new THREE.Mesh(lathe, this.material("MeshLambertMaterial", "steel", { side: THREE.DoubleSide })));
      }
      if (shape.triangles) {
        const geometry = new THREE.BufferGeometry();
        geometry.setAttribute("position", new THREE.Float32BufferAttribute(shape.triangles, 3));
        geometry.computeVertexNormals();
        device.add(new THREE.Mesh(geometry, this.material("MeshLambertMaterial", "steel", { side: THREE.DoubleSide })));
      }
      return device;
    },
    // cylinders, magnetised along their axes: the north half is red
    magnet_of(magnets) {
      const all = new THREE.Group();
      for (const magnet of magnets) {
        const one = new THREE.Group();
        for (const [name, sign] of [["north", 1], ["south", -1]]) {
          const half = new THREE.Mesh(new THREE.CylinderGeometry(magnet.radius, magnet.radius, magnet.height / 2, 40), this.material("MeshLambertMaterial", name));
          half.rotation.x = Math.PI / 2;
          half.position.z = (sign * magnet.height) / 4;
          one.add(half);
        }
        one.userData = magnet;
        all.add(one);
      }
      return all;
    },
    line(values, name, opacity) {
      const geometry = new THREE.BufferGeometry();
      geometry.setAttribute("position", new THREE.Float32BufferAttribute(Float32Array.from(values), 3));
      return new THREE.Line(geometry, this.material("LineBasicMaterial", name, { transparent: opacity < 1, opacity }));
    },
    dashed(values, name, dash) {
      const line = this.line(values, name, 1);
      line.material = this.material("LineDashedMaterial", name, { dashSize: dash, gapSize: 0.7 * dash });
      return line.computeLineDistances();
    },
    arrow(name, length) {
      const arrow = new THREE.Group();
      const [shaft, tip] = [new THREE.CylinderGeometry(0.008 * length, 0.008 * length, length, 10), new THREE.ConeGeometry(0.028 * length, 0.1 * length, 16)];
      shaft.translate(0, length / 2, 0);
      tip.translate(0, length, 0);
      for (const geometry of [shaft, tip]) arrow.add(new THREE.Mesh(geometry, this.material("MeshBasicMaterial", name)));
      return arrow;
    },
    label(words, at, kind) {
      const element = document.createElement("div");
      element.className = kind;
      element.textContent = words;
      const label = new CSS2DObject(element);
      label.position.set(...at);
      return label;
    },
    // lab axes at the origin, and the magnet's own
    frames(size) {
      const triad = (words, length, below) => {
        const frame = new THREE.Group();
        [["x", 1, 0, 0], ["y", 0, 1, 0], ["z", 0, 0, 1]].forEach(([name, ...to]) => {
          const end = to.map((value) => value * length);
          frame.add(this.line([0, 0, 0, ...end], "text", 0.8), this.label(name, end.map((v) => 1.12 * v), "hs-3d"));
        });
        frame.add(this.label(words, [0, 0, -below], "hs-3d hs-quiet"));
        return frame;
      };
      const reach = Math.max(...runs.live.magnets.map((magnet) => Math.hypot(magnet.radius, magnet.height / 2)));
      this.group.add(triad("lab", 0.12 * size, 0.045 * size));
      this.moving = triad("magnet’s frame", Math.max(0.12 * size, 1.4 * reach), reach + 0.04 * size);
      this.group.add(this.moving);
      this.ends = [this.label("head", [0, 0, 0], "hs-3d"), this.label("", [0, 0, 0], "hs-3d")];
      this.group.add(this.ends[0]);
    },
    frame() {
      this.playing = clock.playing;
      this.share = Math.round((1000 * clock.time) / (clock.end || 1));
      if (runs.live && this.device && (this.dirty || clock.playing || this.last !== clock.time)) this.pose(runs.live);
    },
    pose(run) {
      this.last = clock.time;
      this.dirty = false;
      const at = place(run.time, clock.time);
      const head = as_vector(vector(run.position, at));
      const centre = as_vector(vector(run.magnet, at));
      const nose = as_vector(vector(run.nose, at)).normalize();
      const moment = this.moment(run, at);
      this.magnet.position.copy(centre);
      for (const one of this.magnet.children) this.turn_magnet(one, moment, run, at);
      this.turn_device(head, nose, moment, head.clone().sub(centre).normalize(), scalar(run.lag, at));
      this.point(run, head, nose, centre, at);
      this.past.geometry.setDrawRange(0, at[0] + 2);
      if (this.follow) this.camera.position.add(head.clone().sub(this.controls.target));
      if (this.follow) this.controls.target.copy(head);
      this.tell(run, at, head, nose);
      this.controls.update();
      this.dirty = false;
      this.renderer.render(this.scene, this.camera);
      this.labels.render(this.scene, this.camera);
    },
    // the magnet's moment; where it turns too fast to be seen, slowed as under a stroboscope
    moment(run, at) {
      const fast = clock.playing && Math.abs(run.frequency) * clock.speed > FASTEST;
      const whole = run.time[at[0]];
      const phase = fast ? Math.sign(run.frequency) * 2 * Math.PI * SLOWED * clock.wall : run.spin[at[0]] + 2 * Math.PI * run.frequency * (clock.time - whole);
      this.slowed = fast;
      const axis = as_vector(vector(run.axis, at)).normalize();
      const across = as_vector(vector(run.across, at)).normalize();
      return across.clone().multiplyScalar(Math.cos(phase)).addScaledVector(axis.clone().cross(across), Math.sin(phase));
    },
    turn_magnet(one, moment, run, at) {
      const axis = as_vector(vector(run.axis, at)).normalize();
      const own = moment.clone().applyAxisAngle(axis, one.userData.phase);
      one.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), own);
      const across = as_vector(vector(run.across, at)).normalize();
      const [x, y, z] = one.userData.offset;
      one.position.copy(axis.clone().multiplyScalar(x).addScaledVector(across, y).addScaledVector(axis.clone().cross(across), z));
    },
    // its moment lags behind the field that turns about it
    turn_device(head, nose, moment, away, lag) {
      const field = away.clone().multiplyScalar(3 * away.dot(moment)).sub(moment);
      const own = field.addScaledVector(nose, -field.dot(nose)).normalize();
      if (Number.isFinite(lag)) own.applyAxisAngle(nose, (-lag * Math.PI) / 180);
      this.device.position.copy(head);
      this.device.setRotationFromMatrix(new THREE.Matrix4().makeBasis(nose, own, nose.clone().cross(own)));
    },
    point(run, head, nose, centre, at) {
      const up = new THREE.Vector3(0, 1, 0);
      const then = place(run.forces_time, clock.time);
      this.axis.position.copy(head);
      this.axis.quaternion.setFromUnitVectors(up, as_vector(vector(run.field_axis, then)).normalize());
      this.thrust.position.copy(head);
      this.thrust.quaternion.setFromUnitVectors(up, as_vector(vector(run.thrust_vector, then)).normalize());
      this.ends[0].position.copy(head).addScaledVector(nose, 0.045 * this.extent.size);
      this.moving.position.copy(centre);
      const axis = as_vector(vector(run.axis, at));
      this.moving.rotation.z = Math.atan2(axis.y, axis.x);
    },
    // which way it goes, from where it was and will be
    tell(run, at, head, nose) {
      const next = Math.min(at[0] + 1, run.time.length - 1);
      const step = [0, 1, 2].map((i) => run.position[3 * next + i] - run.position[3 * (next - 1) + i]);
      const along = as_vector(step).dot(nose);
      const remarks = [Math.abs(along) < 1e-6 ? "at rest" : along > 0 ? "head leads" : "helix leads"];
      if (this.enlarged > 1) remarks.push(`device drawn ${this.enlarged} × its size`);
      if (this.slowed) remarks.push("turning shown slowed");
      this.told = {
        time: `${clock.time.toFixed(1)} s`,
        height: `height ${written(head.z, 1)} mm`,
        gap: `gap ${scalar(run.gap, at).toFixed(1)} mm`,
        remarks,
      };
    },
    play() {
      clock.toggle();
    },
    scrub(event) {
      clock.playing = false;
      clock.seek((clock.end * event.target.value) / 1000);
    },
  },
};
