// The picture: bodies as instances, and on request contact points, joints and bounding boxes.

import {
  Box3, BufferAttribute, BufferGeometry, Color, DirectionalLight, DynamicDrawUsage, HemisphereLight,
  InstancedBufferAttribute, InstancedMesh, LineBasicMaterial, LineSegments, Matrix4, MeshLambertMaterial, PerspectiveCamera,
  Points, PointsMaterial, Quaternion, Ray, Raycaster, Scene, Sphere, Vector2, Vector3, WebGLRenderer,
} from 'three';
import { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';
import { Flag } from './film.js';
import { colourOf } from './colours.js';
import { collectParts } from './solids.js';

const NOWHERE = new Matrix4().makeScale(0, 0, 0);
const UNBOUNDED = new Set(['half-space', 'mesh']);  // ground, which nobody looks through

// Lines or points of which every frame has another number.
class Marks {
  constructor(object, capacity) {
    this.object = object;
    this.object.frustumCulled = false;
    this.object.visible = false;
    this.reserve(capacity);
  }
  reserve(count) {
    if (this.positions?.length >= 3 * count) return;
    this.positions = new Float32Array(3 * Math.ceil(1.5 * count + 16));
    this.object.geometry.dispose();
    this.object.geometry = new BufferGeometry();
    this.object.geometry.setAttribute('position', new BufferAttribute(this.positions, 3).setUsage(DynamicDrawUsage));
  }
  show(count) {
    this.object.geometry.setDrawRange(0, count);
    this.object.geometry.attributes.position.needsUpdate = true;
  }
}

export class Stage {
  constructor(canvas, film) {
    this.film = film;
    this.canvas = canvas;
    this.renderer = new WebGLRenderer({ canvas, antialias: true, preserveDrawingBuffer: true });
    this.scene = new Scene();
    this.camera = new PerspectiveCamera(45, 1, 0.05, 5000);
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.enableDamping = false;
    this.sky = new HemisphereLight(0xffffff, 0x7d838c, 1.7);
    this.sky.position.set(0, 0, 1);
    this.sun = new DirectionalLight(0xffffff, 1.3);
    this.scene.add(this.sky, this.sun, this.sun.target);
    this.way = 'body';
    this.selected = null;
    this.bodyOf = new Map();  // by mesh: body numbers of its instances
    this.kept = [];           // a matrix a body, used again in each frame
  }

  // `frame` says where things happen.
  async build(frame) {
    const room = this.roomOf(frame);
    const seenFrom = (body) => {
      const pose = this.film.pose(frame, body);
      if (!pose) return room;
      const center = room.center.clone().sub(new Vector3(...pose.position));
      return { center: center.applyQuaternion(new Quaternion(...pose.orientation).invert()), radius: room.radius };
    };
    this.meshes = (await collectParts(this.film, seenFrom)).map((set) => {
      const mesh = new InstancedMesh(set.geometry, new MeshLambertMaterial(), set.members.length);
      mesh.instanceMatrix.setUsage(DynamicDrawUsage);
      mesh.instanceColor = new InstancedBufferAttribute(new Float32Array(3 * set.members.length), 3);
      mesh.frustumCulled = false;
      mesh.userData.members = set.members;
      this.scene.add(mesh);
      return mesh;
    });
    const lines = (colour) => new LineSegments(new BufferGeometry(), new LineBasicMaterial({ color: colour, depthTest: false }));
    this.contacts = new Marks(new Points(new BufferGeometry(),
                                         new PointsMaterial({ color: 0xd1242f, size: 4, sizeAttenuation: false, depthTest: false })), 64);
    this.forces = new Marks(lines(0xd1242f), 64);
    this.joints = new Marks(lines(0x0b63c5), 64);
    this.boxes = new Marks(lines(0x8250df), 64);
    this.outline = new Marks(lines(0xf59f00), 24);
    this.walls = new Marks(lines(0x8a929b), 24);
    this.walls.object.material.depthTest = true;
    this.walls.object.visible = true;
    for (const marks of [this.walls, this.contacts, this.forces, this.joints, this.boxes, this.outline]) this.scene.add(marks.object);
    this.bounds = this.boundsOfBodies();
  }

  // A sphere about what moves. How large bodies are, places are rounded by.
  roomOf(frame) {
    const all = new Box3();
    for (let body = 0; body < frame.bodies; ++body) {
      const pose = this.film.bodies[body].type === 'static' ? null : this.film.pose(frame, body);
      if (pose) all.expandByPoint(new Vector3(...pose.position));
    }
    if (all.isEmpty()) all.expandByPoint(new Vector3());
    const room = all.getBoundingSphere(new Sphere());
    room.radius += 2000 * this.film.data.precision;
    return room;
  }

  // Local bounding box by body, of what is bounded.
  boundsOfBodies() {
    const bounds = this.film.bodies.map(() => new Box3());
    for (const mesh of this.meshes) {
      mesh.geometry.computeBoundingBox();
      for (const { body, local } of mesh.userData.members) {
        bounds[body].union(mesh.geometry.boundingBox.clone().applyMatrix4(local));
      }
    }
    return bounds;
  }

  // Looks at the dynamic bodies of a frame, from the south and above.
  frameAll(frame) {
    const places = [];
    const all = new Box3();
    for (let body = 0; body < frame.bodies; ++body) {
      const pose = this.film.pose(frame, body);
      if (!pose) continue;
      const { type, shape } = this.film.bodies[body];
      if (this.film.data.shapes[shape].type === 'half-space' || type === 'static') continue;
      places.push(new Vector3(...pose.position));
      const radius = this.bounds[body].getBoundingSphere(new Sphere()).radius;
      all.expandByPoint(places.at(-1).clone().addScalar(radius)).expandByPoint(places.at(-1).clone().addScalar(-radius));
    }
    if (all.isEmpty()) all.set(new Vector3(-5, -5, 0), new Vector3(5, 5, 5));
    const sphere = all.getBoundingSphere(new Sphere());
    const far = 0.85 * sphere.radius / Math.sin((this.camera.fov / 2) * Math.PI / 180) / Math.min(1, this.camera.aspect);
    this.controls.target.copy(sphere.center);
    this.camera.position.copy(sphere.center).add(new Vector3(0.45, -0.8, 0.4).normalize().multiplyScalar(far));
    this.camera.near = far / 500;
    this.camera.far = far * 20 + 500;
    this.camera.updateProjectionMatrix();
    this.controls.update();
    this.sun.position.copy(sphere.center).add(new Vector3(-0.4, -0.5, 1).multiplyScalar(far));
    this.sun.target.position.copy(sphere.center);
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (width === 0 || height === 0) return;
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
  }

  background(css) { this.scene.background = new Color(css); }

  // The data of a body that colours and the panel show. `former` is the frame before, for speeds.
  bodyIn(frame, former, number) {
    const cell = frame.at + number;
    return {
      number, type: this.film.bodies[number].type, flags: frame.chunk.flags[cell], force: frame.chunk.force[cell],
      island: frame.chunk.island[cell],
      speed: this.way === 'speed' ? this.velocity(frame, former, number)?.length() ?? 0 : 0,
    };
  }
  velocity(frame, former, number) {
    if (!former) return null;
    const now = this.film.pose(frame, number), then = this.film.pose(former, number);
    if (!now || !then) return null;
    return new Vector3(...now.position).sub(new Vector3(...then.position)).divideScalar(former.seconds);
  }

  show(frame, former) {
    const matrices = new Array(frame.bodies).fill(null);
    const place = [0, 0, 0], turned = [0, 0, 0, 1];
    const position = new Vector3(), turn = new Quaternion(), one = new Vector3(1, 1, 1), full = new Matrix4();
    while (this.kept.length < frame.bodies) this.kept.push(new Matrix4());
    for (let body = 0; body < frame.bodies; ++body) {
      if (!this.film.isThere(frame, body)) continue;
      this.film.readPose(frame, body, place, turned);
      matrices[body] = this.kept[body].compose(position.fromArray(place), turn.fromArray(turned), one);
    }
    this.matrices = matrices;
    const hidden = this.findHiding(frame);
    const colours = new Array(frame.bodies);
    const colour = (body) => (colours[body] ??= colourOf(this.way, this.bodyIn(frame, former, body)));
    for (const mesh of this.meshes) {
      mesh.userData.members.forEach(({ body, local }, i) => {
        const at = hidden.has(body) ? null : matrices[body];
        (at ? full.multiplyMatrices(at, local) : NOWHERE).toArray(mesh.instanceMatrix.array, 16 * i);
        if (!at) return;
        const rgb = colour(body), shades = mesh.instanceColor.array;
        for (let k = 0; k < 3; ++k) shades[3 * i + k] = rgb[k];
      });
      mesh.instanceMatrix.needsUpdate = true;
      mesh.instanceColor.needsUpdate = true;
      mesh.boundingSphere = null;  // picking asks for it
    }
    if (this.joints.object.visible) this.showJoints(frame);
    if (this.boxes.object.visible) this.showBoxes(frame);
    this.showOutline();
  }

  // Static bodies in the way of moving ones, which are drawn as their edges.
  findHiding(frame) {
    const seen = [];
    const moving = [];
    for (let body = 0; body < frame.bodies; ++body) {
      if (!this.matrices[body]) continue;
      if (this.film.bodies[body].type !== 'static') moving.push(body);
      else if (!UNBOUNDED.has(this.film.data.shapes[this.film.bodies[body].shape].type)) seen.push(body);
    }
    const every = Math.max(1, Math.floor(moving.length / 64));
    const eye = this.camera.position, ray = new Ray(eye.clone()), at = new Vector3();
    const hidden = new Set();
    for (const body of seen) {
      const box = this.bounds[body].clone().applyMatrix4(this.matrices[body]);
      for (let i = 0; i < moving.length && !hidden.has(body); i += every) {
        const middle = at.setFromMatrixPosition(this.matrices[moving[i]]);
        const far = ray.direction.copy(middle).sub(eye).length();
        ray.direction.divideScalar(far);
        const hit = ray.intersectBox(box, new Vector3());
        if (hit && hit.distanceTo(eye) < 0.98 * far) hidden.add(body);
      }
    }
    this.walls.reserve(24 * hidden.size);
    let count = 0;
    for (const body of hidden) count = this.boxLines(this.walls, count, body);
    this.walls.show(count);
    return hidden;
  }

  showJoints(frame) {
    const there = this.film.joints.filter((joint) => joint.from <= frame.number && frame.number < joint.to &&
                                                     this.matrices[joint.first] && this.matrices[joint.second]);
    this.joints.reserve(6 * there.length);
    let at = 0;
    const point = new Vector3();
    for (const joint of there) {
      const ends = [[joint.first, [0, 0, 0]], [joint.first, joint.anchor_first],
                    [joint.first, joint.anchor_first], [joint.second, joint.anchor_second],
                    [joint.second, joint.anchor_second], [joint.second, [0, 0, 0]]];
      // A static body may be of any size: no line goes to its middle.
      for (let i = 0; i < 6; i += 2) {
        if (i !== 2 && this.film.bodies[ends[i][0]].type === 'static') continue;
        for (const [body, local] of [ends[i], ends[i + 1]]) {
          point.set(...local).applyMatrix4(this.matrices[body]).toArray(this.joints.positions, 3 * at++);
        }
      }
    }
    this.joints.show(at);
  }

  boxLines(marks, at, body) {
    const box = this.bounds[body].clone().applyMatrix4(this.matrices[body]);
    const corner = (i) => [i & 1 ? box.max.x : box.min.x, i & 2 ? box.max.y : box.min.y, i & 4 ? box.max.z : box.min.z];
    for (let i = 0; i < 8; ++i) {
      for (const bit of [1, 2, 4]) {
        if (i & bit) continue;
        marks.positions.set(corner(i), 3 * at++);
        marks.positions.set(corner(i | bit), 3 * at++);
      }
    }
    return at;
  }
  showBoxes(frame) {
    this.boxes.reserve(24 * frame.bodies);
    let at = 0;
    for (let body = 0; body < frame.bodies; ++body) {
      if (this.matrices[body] && this.film.data.shapes[this.film.bodies[body].shape].type !== 'half-space') {
        at = this.boxLines(this.boxes, at, body);
      }
    }
    this.boxes.show(at);
  }
  showOutline() {
    const there = this.selected !== null && this.matrices[this.selected];
    this.outline.object.visible = Boolean(there);
    if (there) this.outline.show(this.boxLines(this.outline, 0, this.selected));
  }

  // Forces are drawn by their logarithm: 1 MN as 7 times `unit`.
  showContacts(contacts, unit) {
    const count = contacts.to - contacts.from;
    this.contacts.reserve(count);
    this.forces.reserve(2 * count);
    for (let i = 0; i < count; ++i) {
      const place = contacts.place(contacts.from + i), normal = contacts.normal(contacts.from + i);
      const length = unit * (1 + Math.log10(1 + contacts.force(contacts.from + i)));
      this.contacts.positions.set(place, 3 * i);
      this.forces.positions.set(place, 6 * i);
      for (let k = 0; k < 3; ++k) this.forces.positions[6 * i + 3 + k] = place[k] + length * normal[k];
    }
    this.contacts.show(count);
    this.forces.show(2 * count);
  }

  pick(x, y) {
    const ray = new Raycaster();
    ray.setFromCamera(new Vector2(x, y), this.camera);
    for (const hit of ray.intersectObjects(this.meshes, false)) return hit.object.userData.members[hit.instanceId].body;
    return null;
  }

  draw() { this.renderer.render(this.scene, this.camera); }
}
