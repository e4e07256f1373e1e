/**
 * A panorama that slowly turns to and fro, for looks alone: six pictures on the inside of a box, which the
 * browser turns by itself. It needs neither WebGL nor three.js, and nothing of it is there for
 * people who asked for less motion.
 */
import { make } from '../elements/page.ts';
import { apply, degrees, type Mat3, transpose, wrapDifference, worldFromCamera, wrapHeading } from '../geometry/geometry.ts';
import type { Api } from '../server/api.ts';
import { Surround } from './surround.ts';

/** Radians. */
export interface Look {
  readonly heading: number;
  readonly elevation: number;
  /** From top to bottom. */
  readonly vfov: number;
}

/** It turns to either side of the look by so much at most, and at least. */
const mostSweep = degrees(60);
const leastSweep = degrees(10);
/** Metres: it does not turn to where the middle of the picture shows something nearer. */
const open = 2;
const sweepStep = degrees(5);
/** On an average. */
const speed = degrees(3); // a second
/** The motion is a sine; browsers join keyframes by lines. */
const keyframes = 60;
/** In CSS pixels: so large that rounding to pixels does not show. */
const edge = 1000;
/** Pictures reach a little over the box's edges: else the background shines through. */
const overlap = 1;

/** How the faces up, back, left, front, right, down (the server's order) are turned about the eye. */
export const turns = [
  'rotateX(-90deg) rotateZ(180deg)', 'rotateY(180deg)', 'rotateY(90deg)', '', 'rotateY(-90deg)', 'rotateX(90deg) rotateZ(180deg)',
] as const;

/** The world's heading of the panorama's front face. */
const frontHeading = (worldFromPanorama: Mat3): number => Math.atan2(worldFromPanorama[2], worldFromPanorama[5]);

/** CSS that turns the box so that one looks there. CSS has x right, y down, z towards us, as the panorama has except for z. */
export function boxTransform(focal: number, { heading, elevation }: Look, front: number): string {
  const turn = wrapDifference(heading - front);
  return `translateZ(${focal.toFixed(2)}px) rotateX(${elevation.toFixed(5)}rad) rotateY(${turn.toFixed(5)}rad)`;
}

/** How far it may turn to the left (below 0) and to the right of a look, radians: while there is something to see. */
type Sweep = readonly [left: number, right: number];

const widestSweep: Sweep = [-mostSweep, mostSweep];

/** What is open around a look: up to 60 degrees to either side, and 10 in any case. */
export function sweepOf(surround: Surround, worldFromPanorama: Mat3, { heading, elevation }: Look): Sweep {
  const panoramaFromWorld = transpose(worldFromPanorama);
  const seen = (turn: number): number => {
    const middle = [-sweepStep, 0, sweepStep].map((aside) => {
      const m = worldFromCamera({ heading: heading + turn + aside, elevation });
      return surround.at(apply(panoramaFromWorld, [m[2], m[5], m[8]]));
    });
    return middle.reduce((a, b) => a + b) / middle.length;
  };
  const [left = 0, right = 0] = [-1, 1].map((side) => {
    let turn = 0;
    while (turn < mostSweep - 1e-9 && seen(side * (turn + sweepStep)) >= open) turn += sweepStep;
    return side * Math.max(turn, leastSweep);
  });
  return [left, right];
}

/** How long the way to and fro takes, and where it looks then, radians from the look: there it begins. */
export function swing([left, right]: Sweep): { readonly seconds: number; readonly turn: (seconds: number) => number } {
  const [middle, half] = [(left + right) / 2, (right - left) / 2];
  const seconds = (4 * half) / speed;
  const begin = Math.asin(Math.min(Math.max(-middle / half, -1), 1));
  return { seconds, turn: (at) => middle + half * Math.sin(begin + (2 * Math.PI * at) / seconds) };
}

export class TurningPanorama {
  readonly element = make('div', { class: 'box', 'aria-hidden': 'true' });
  private readonly box = make('div');
  private readonly look: Look;
  private readonly front: number;
  private readonly swing: ReturnType<typeof swing>;
  private animation: Animation | undefined;
  /** Also before there is an animation: people press the button as soon as it is there. */
  private paused = false;

  constructor(look: Look, worldFromPanorama: Mat3, faces: readonly HTMLImageElement[], sweep: Sweep = widestSweep) {
    this.look = look;
    this.swing = swing(sweep);
    this.front = frontHeading(worldFromPanorama);
    faces.forEach((face, k) => {
      face.style.transform = `translate(-50%, -50%) ${turns[k]} translateZ(${-edge / 2}px)`; // to the middle, out, turned
      face.style.width = face.style.height = `${edge + 2 * overlap}px`;
    });
    this.box.append(...faces);
    this.element.append(this.box);
    new ResizeObserver(() => this.resize()).observe(this.element);
  }

  get playing(): boolean {
    return !this.paused;
  }

  /** Where it looks now. */
  get heading(): number {
    return wrapHeading(this.look.heading + this.swing.turn(Number(this.animation?.currentTime ?? 0) / 1000));
  }

  play(): void {
    this.paused = false;
    this.animation?.play();
  }

  pause(): void {
    this.paused = true;
    this.animation?.pause();
  }

  private resize(): void {
    const focal = this.element.clientHeight / 2 / Math.tan(this.look.vfov / 2);
    if (focal === 0) return;
    this.element.style.perspective = `${focal}px`;
    const at = this.animation?.currentTime ?? 0;
    this.animation?.cancel();
    const begin = boxTransform(focal, this.look, this.front);
    const { seconds, turn } = this.swing;
    const moments = Array.from({ length: keyframes + 1 }, (_, k) =>
      ({ transform: `${begin} rotateY(${turn((seconds * k) / keyframes).toFixed(5)}rad)` }));
    this.animation = this.box.animate(moments, { duration: seconds * 1000, iterations: Infinity });
    this.animation.currentTime = at;
    if (this.paused) this.animation.pause();
  }
}

/** The sweep at a viewpoint, by its distances; the widest where there are none. */
export const loadSweep = (api: Api, scan: string, viewpoint: string, worldFromPanorama: Mat3, look: Look): Promise<Sweep> =>
  api.distances(scan, viewpoint).then((bytes) => sweepOf(Surround.parse(bytes), worldFromPanorama, look)).catch(() => widestSweep);

/** The pictures of a viewpoint, decoded: a box with holes would flash. */
export async function loadFaces(api: Api, scan: string, viewpoint: string): Promise<HTMLImageElement[]> {
  const faces = [0, 1, 2, 3, 4, 5].map((face) => make('img', { src: api.face(scan, viewpoint, 'colour', face), alt: '' }));
  await Promise.all(faces.map((face) => face.decode()));
  return faces;
}
