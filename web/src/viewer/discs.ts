/** Discs on the floor: where one can go, and the marks of a path. */
import * as three from 'three';
import { norm, subtract, transpose, type Vec3 } from '../geometry/geometry.ts';
import type { Scan } from '../scan/scan.ts';
import type { Panorama } from './panorama.ts';

export type Mark = 'step' | 'candidate' | 'path' | 'start' | 'goal' | 'seen';

/** Told apart by shape as well: a step is a ring, a path's disc full, start and goal have poles. */
const looks: Record<Mark, { colour: number; inner: number; pole: number }> = {
  step: { colour: 0xffffff, inner: 0.62, pole: 0 },
  candidate: { colour: 0xff9800, inner: 0.62, pole: 0 },
  path: { colour: 0x2b7bff, inner: 0, pole: 0 },
  start: { colour: 0x0aa36b, inner: 0, pole: 0.9 },
  goal: { colour: 0xe8453c, inner: 0, pole: 1.4 },
  seen: { colour: 0xf0e442, inner: 0.4, pole: 0 }, // of a goal's object or region
};

/** Metres; and the least angle that a disc is seen under, so that distant ones can be hit. */
const radius = 0.2;
const leastAngle = 0.035;
/** Assumed eye height where a scan doesn't say, metres. */
const usualHeight = 1.5;
const opacity = 0.85;
/** How much larger the disc is that a click would go to. */
const chosen = 1.25;

/** The point of the floor below a viewpoint. */
export function floorBelow(scan: Scan, viewpoint: number): Vec3 {
  const { position, height } = scan.viewpoints[viewpoint]!;
  return [position[0], position[1], position[2] - (height > 0 ? height : usualHeight)];
}

const rimEdge = 1.12;
const rimColour = 0x10202a; // seen on floors of any colour

const vertexShader = /* glsl */ `
  out vec3 ray;
  out vec2 place;
  out vec3 surface;
  uniform vec3 eye;
  void main() {
    vec4 world = modelMatrix * vec4(position, 1.0);
    ray = world.xyz - eye;
    place = position.xy;
    surface = normal;
    gl_Position = projectionMatrix * viewMatrix * world;
  }`;

/**
 * What stands before a mark leaves a trace of it, so that one knows that there is a way. Distances
 * are compared as shares: those to the floor far away are known to a few per cent only. Edges are
 * smooth by themselves: multisampling costs a quarter of a frame where there is no GPU.
 */
const fragmentShader = /* glsl */ `
  in vec3 ray;
  in vec2 place;
  in vec3 surface;
  out vec4 colour;
  uniform vec3 tint;
  uniform vec3 rim;
  uniform float inner;
  uniform float opacity;
  uniform bool hides;
  uniform samplerCube distances;
  uniform mat3 panoramaFromWorld;
  void main() {
    float alpha = opacity;
    vec3 shade = tint;
    #ifdef POLE
      float facing = abs(dot(normalize(surface), normalize(vec3(ray.xy, 0.0))));
      alpha *= min(facing / fwidth(facing), 1.0);
    #else
      float r = length(place);
      float pixel = fwidth(r);
      shade = mix(tint, rim, smoothstep(1.0 - 0.5 * pixel, 1.0 + 0.5 * pixel, r));
      alpha *= 1.0 - smoothstep(${rimEdge} - 0.5 * pixel, ${rimEdge} + 0.5 * pixel, r);
      if (inner > 0.0) alpha *= smoothstep(inner - 0.5 * pixel, inner + 0.5 * pixel, r);
    #endif
    if (hides) {
      float free = texture(distances, -(panoramaFromWorld * ray)).r / length(ray);
      alpha *= 1.0 - 0.85 * smoothstep(0.08, 0.16, 1.0 - free);
    }
    colour = vec4(shade, alpha);
  }`;

export class Discs {
  readonly group = new three.Group();
  private readonly square = new three.PlaneGeometry(2.6, 2.6); // with room for the edge of the rim
  private readonly pole = new three.CylinderGeometry(0.04, 0.04, 1, 12).rotateX(Math.PI / 2);
  private readonly materials = new Map<string, three.ShaderMaterial>();
  private readonly common = {
    eye: { value: new three.Vector3() },
    hides: { value: false },
    distances: { value: null as three.CubeTexture | null },
    panoramaFromWorld: { value: new three.Matrix3() },
  };
  private readonly opacities = { step: { value: opacity }, path: { value: opacity } };
  private discs = new Map<number, { disc: three.Group; size: number }>();

  /** Replaces all. `marks`: by viewpoint; the present one has no disc, as one stands on it. */
  set(scan: Scan, eye: Vec3, marks: ReadonlyMap<number, Mark>): void {
    this.group.clear();
    this.discs.clear();
    for (const [viewpoint, mark] of marks) {
      const floor = floorBelow(scan, viewpoint);
      const away = norm(subtract(floor, eye));
      this.addDisc(viewpoint, floor, Math.max(radius, leastAngle * away), mark);
    }
  }

  /** Makes one disc larger, or none. */
  choose(viewpoint: number | undefined): void {
    for (const [v, { disc, size }] of this.discs) disc.scale.setScalar(v === viewpoint ? size * chosen : size);
  }

  /** From now on what a panorama shows stands before the discs, if its distances are known. */
  hideBehind({ position, rotation, distances }: Panorama): void {
    this.common.eye.value.set(...position);
    this.common.panoramaFromWorld.value.set(...transpose(rotation));
    this.common.hides.value = distances !== undefined;
    this.common.distances.value = distances?.texture ?? null;
  }

  /** 0 to 1: of where one can go from here, and of a path, which stays while one goes along it. */
  setOpacity(steps: number, path: number): void {
    this.opacities.step.value = opacity * steps;
    this.opacities.path.value = opacity * path;
  }

  dispose(): void {
    for (const geometry of [this.square, this.pole]) geometry.dispose();
    for (const material of this.materials.values()) material.dispose();
  }

  private addDisc(viewpoint: number, floor: Vec3, size: number, mark: Mark): void {
    const look = looks[mark];
    const disc = new three.Group();
    disc.position.set(...floor);
    disc.scale.setScalar(size);
    const kind = mark === 'step' || mark === 'candidate' ? 'step' : 'path';
    disc.add(this.mesh('disc', look, kind));
    if (look.pole > 0) {
      const pole = this.mesh('pole', look, kind);
      pole.scale.set(1, 1, look.pole / size);
      pole.position.z = look.pole / size / 2;
      disc.add(pole);
    }
    this.group.add(disc);
    this.discs.set(viewpoint, { disc, size });
  }

  private mesh(shape: 'disc' | 'pole', { colour, inner }: (typeof looks)[Mark], kind: 'step' | 'path'): three.Mesh {
    const key = `${shape} ${kind} ${colour}`;
    let material = this.materials.get(key);
    if (!material) {
      const tint = (hex: number) => ({ value: new three.Color().setHex(hex, three.LinearSRGBColorSpace) });
      material = new three.ShaderMaterial({
        glslVersion: three.GLSL3,
        vertexShader,
        fragmentShader,
        defines: shape === 'pole' ? { POLE: 1 } : {},
        uniforms: {
          ...this.common, opacity: this.opacities[kind], tint: tint(colour), rim: tint(rimColour), inner: { value: inner },
        },
        transparent: true,
        depthTest: false,
        depthWrite: false,
        side: three.DoubleSide,
      });
      this.materials.set(key, material);
    }
    const mesh = new three.Mesh(shape === 'pole' ? this.pole : this.square, material);
    mesh.renderOrder = shape === 'pole' ? 21 : 20;
    return mesh;
  }
}
