/** Discs on the floor: where one can go, and the marks of a path. */
import * as three from 'three';
import { type Vec3, norm, subtract } from '../geometry.ts';
import type { Scan } from '../scan.ts';

export type Mark = 'step' | 'candidate' | 'path' | 'start' | 'goal';

/** Told apart by shape as well: a step is a ring, a path's disc full, start and goal have poles. */
const looks: Record<Mark, { colour: number; inner: number; pole: number }> = {
  step: { colour: 0xffffff, inner: 0.62, pole: 0 },
  candidate: { colour: 0xff9800, inner: 0.62, pole: 0 },
  path: { colour: 0x2b7bff, inner: 0, pole: 0 },
  start: { colour: 0x0aa36b, inner: 0, pole: 0.9 },
  goal: { colour: 0xe8453c, inner: 0, pole: 1.4 },
};

/** Metres; and the least angle that a disc is seen under, so that distant ones can be hit. */
const radius = 0.2;
const leastAngle = 0.035;
/** Assumed eye height where a scan doesn't say, metres. */
const usualHeight = 1.5;

/** The point of the floor below a viewpoint. */
export function floorBelow(scan: Scan, viewpoint: number): Vec3 {
  const { position, height } = scan.viewpoints[viewpoint]!;
  return [position[0], position[1], position[2] - (height > 0 ? height : usualHeight)];
}

export class Discs {
  readonly group = new three.Group();
  private readonly ring = new three.RingGeometry(0.62, 1, 48);
  private readonly full = new three.CircleGeometry(1, 48);
  private readonly rim = new three.RingGeometry(1, 1.12, 48);
  private readonly pole = new three.CylinderGeometry(0.04, 0.04, 1, 12).rotateX(Math.PI / 2);
  private readonly materials = new Map<number, three.MeshBasicMaterial>();

  /** Replaces all. `marks`: by viewpoint; the present one has no disc, as one stands on it. */
  set(scan: Scan, eye: Vec3, marks: ReadonlyMap<number, Mark>): void {
    this.group.clear();
    for (const [viewpoint, mark] of marks) {
      const floor = floorBelow(scan, viewpoint);
      const away = norm(subtract(floor, eye));
      this.addDisc(floor, Math.max(radius, leastAngle * away), mark);
    }
  }

  dispose(): void {
    for (const geometry of [this.ring, this.full, this.rim, this.pole]) geometry.dispose();
    for (const material of this.materials.values()) material.dispose();
  }

  private addDisc(floor: Vec3, size: number, mark: Mark): void {
    const look = looks[mark];
    const disc = new three.Group();
    disc.position.set(...floor);
    disc.scale.setScalar(size);
    disc.add(this.mesh(look.inner > 0 ? this.ring : this.full, look.colour, 20));
    disc.add(this.mesh(this.rim, 0x10202a, 20)); // seen on floors of any colour
    if (look.pole > 0) {
      const pole = this.mesh(this.pole, look.colour, 21);
      pole.scale.set(1, 1, look.pole / size);
      pole.position.z = look.pole / size / 2;
      disc.add(pole);
    }
    this.group.add(disc);
  }

  private mesh(geometry: three.BufferGeometry, colour: number, order: number): three.Mesh {
    let material = this.materials.get(colour);
    if (!material) {
      material = new three.MeshBasicMaterial({
        color: new three.Color().setHex(colour, three.LinearSRGBColorSpace),
        transparent: true,
        opacity: 0.85,
        depthTest: false,
        depthWrite: false,
        side: three.DoubleSide,
      });
      this.materials.set(colour, material);
    }
    const mesh = new three.Mesh(geometry, material);
    mesh.renderOrder = order;
    return mesh;
  }
}
