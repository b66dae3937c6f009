// Shapes as three.js geometry. What differs in size alone shares one: bodies are instances of it, each with a scale.

import {
  BoxGeometry, BufferAttribute, BufferGeometry, ConeGeometry, CylinderGeometry, Matrix4, PlaneGeometry, Quaternion,
  SphereGeometry, Vector3,
} from 'three';
import { unpack } from './film.js';

const upright = (geometry) => geometry.rotateX(Math.PI / 2);  // three.js has axes along y, Atoll along z
const unit = {
  box: () => new BoxGeometry(2, 2, 2),
  sphere: () => new SphereGeometry(1, 24, 16),
  cylinder: () => upright(new CylinderGeometry(1, 1, 2, 24)),
  tube: () => upright(new CylinderGeometry(1, 1, 2, 24, 1, true)),
  cone: () => upright(new ConeGeometry(1, 2, 24)),
  plane: () => new PlaneGeometry(2, 2),
};

const placed = (x, y, z, scale) => new Matrix4().makeTranslation(x, y, z).scale(new Vector3(...scale));

async function surface(shape) {
  const geometry = new BufferGeometry();
  const vertices = new Float32Array((await unpack(shape.vertices)).buffer);
  geometry.setAttribute('position', new BufferAttribute(vertices, 3));
  geometry.setIndex(new BufferAttribute(new Uint32Array((await unpack(shape.triangles)).buffer), 1));
  const flat = geometry.toNonIndexed();
  flat.computeVertexNormals();
  return flat;
}

// The parts of a shape: [{ key, geometry(), local }], parts with the same key having the same geometry. Of a half-space
// that is a square about the place nearest to the middle of `room`, a sphere in the body's frame.
function partsOf(shapes, number, room) {
  const shape = shapes[number];
  switch (shape.type) {
    case 'box':
      return [{ key: 'box', geometry: unit.box, local: placed(0, 0, 0, shape.half) }];
    case 'sphere':
      return [{ key: 'sphere', geometry: unit.sphere, local: placed(0, 0, 0, Array(3).fill(shape.radius)) }];
    case 'cylinder':
    case 'cone':
      return [{ key: shape.type, geometry: unit[shape.type],
                local: placed(0, 0, 0, [shape.radius, shape.radius, shape.half_height]) }];
    case 'capsule':
      return [
        { key: 'tube', geometry: unit.tube, local: placed(0, 0, 0, [shape.radius, shape.radius, shape.half_height]) },
        ...[-1, 1].map((side) => ({ key: 'sphere', geometry: unit.sphere,
                                    local: placed(0, 0, side * shape.half_height, Array(3).fill(shape.radius)) })),
      ];
    case 'ellipsoid':
      return [{ key: 'sphere', geometry: unit.sphere, local: placed(0, 0, 0, shape.half) }];
    case 'tapered_capsule': {
      // The cone around both balls touches them in circles; its normals lean by this sine.
      const sine = (shape.radii[0] - shape.radii[1]) / (2 * shape.half_height);
      const circles = shape.radii.map((radius) => radius * Math.sqrt(1 - sine * sine));
      const [low, high] = [-1, 1].map((side, i) => side * shape.half_height + sine * shape.radii[i]);
      const cone = () => upright(new CylinderGeometry(circles[1], circles[0], high - low, 24, 1, true));
      return [
        { key: `cone of ${circles} ${high - low}`, geometry: cone, local: placed(0, 0, (low + high) / 2, [1, 1, 1]) },
        ...[-1, 1].map((side, i) => ({ key: 'sphere', geometry: unit.sphere,
                                       local: placed(0, 0, side * shape.half_height, Array(3).fill(shape.radii[i])) })),
      ];
    }
    case 'half-space': {
      const normal = new Vector3(...shape.normal);
      const turn = new Quaternion().setFromUnitVectors(new Vector3(0, 0, 1), normal);
      const place = room.center.clone().addScaledVector(normal, shape.offset - normal.dot(room.center));
      const half = 2.5 * room.radius;
      return [{ key: 'plane', geometry: unit.plane,
                local: new Matrix4().compose(place, turn, new Vector3(half, half, 1)) }];
    }
    case 'compound':
      return shape.children.flatMap((child) => {
        const at = new Matrix4().compose(new Vector3(...child.position), new Quaternion(...child.orientation),
                                         new Vector3(1, 1, 1));
        return partsOf(shapes, child.shape, room).map((part) => ({ ...part, local: at.clone().multiply(part.local) }));
      });
    default:
      return [{ key: `surface ${number}`, geometry: () => surface(shape), local: new Matrix4() }];
  }
}

// All parts of all bodies by geometry: [{ key, geometry, members: [{ body, local }] }]. `roomOf(body)`: what happens, in
// the body's frame.
export async function collectParts(film, roomOf) {
  const sets = new Map();
  for (let body = 0; body < film.bodies.length; ++body) {
    for (const part of partsOf(film.data.shapes, film.bodies[body].shape, roomOf(body))) {
      if (!sets.has(part.key)) sets.set(part.key, { key: part.key, geometry: part.geometry, members: [] });
      sets.get(part.key).members.push({ body, local: part.local });
    }
  }
  for (const set of sets.values()) set.geometry = await set.geometry();
  return [...sets.values()];
}
