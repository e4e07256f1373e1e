/**
 * A panorama that turns slowly, for looks alone: six pictures on the inside of a box, which the
 * browser turns by itself. It needs neither WebGL nor three.js, and nothing of it is there for
 * people who asked for less motion.
 */
import { make } from '../elements/page.ts';
import { type Mat3, wrapDifference } from '../geometry/geometry.ts';
import type { Api } from '../server/api.ts';

/** Radians. */
export interface Look {
  readonly heading: number;
  readonly elevation: number;
  /** From top to bottom. */
  readonly vfov: number;
}

const secondsATurn = 120;
/** In CSS pixels: so large that rounding to pixels does not show. */
const edge = 1000;
/** Pictures reach a little over the box's edges: else the background shines through. */
const overlap = 1;

/** How the faces up, back, left, front, right, down (the server's order) are turned about the eye. */
export const turns = ['rotateX(-90deg) rotateZ(180deg)', 'rotateY(180deg)', 'rotateY(90deg)', '', 'rotateY(-90deg)', 'rotateX(90deg) rotateZ(180deg)'] as const;

/** The world's heading of the panorama's front face. */
const frontHeading = (worldFromPanorama: Mat3): number => Math.atan2(worldFromPanorama[2], worldFromPanorama[5]);

/** CSS that turns the box so that one looks there. CSS has x right, y down, z towards us, as the panorama has except for z. */
export function boxTransform(focal: number, { heading, elevation }: Look, front: number): string {
  const turn = wrapDifference(heading - front);
  return `translateZ(${focal.toFixed(2)}px) rotateX(${elevation.toFixed(5)}rad) rotateY(${turn.toFixed(5)}rad)`;
}

export class TurningPanorama {
  readonly element = make('div', { class: 'box', 'aria-hidden': 'true' });
  private readonly box = make('div');
  private readonly look: Look;
  private readonly front: number;
  private animation: Animation | undefined;

  constructor(look: Look, worldFromPanorama: Mat3, faces: readonly HTMLImageElement[]) {
    this.look = look;
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
    return this.animation?.playState === 'running';
  }

  play(): void {
    this.animation?.play();
  }

  pause(): void {
    this.animation?.pause();
  }

  private resize(): void {
    const focal = this.element.clientHeight / 2 / Math.tan(this.look.vfov / 2);
    if (focal === 0) return;
    this.element.style.perspective = `${focal}px`;
    const at = this.animation?.currentTime ?? 0;
    const paused = this.animation?.playState === 'paused';
    this.animation?.cancel();
    const begin = boxTransform(focal, this.look, this.front);
    const turn = ` rotateY(${2 * Math.PI}rad)`;
    this.animation = this.box.animate([{ transform: begin }, { transform: begin + turn }],
      { duration: secondsATurn * 1000, iterations: Infinity });
    this.animation.currentTime = at;
    if (paused) this.animation.pause();
  }
}

/** The pictures of a viewpoint, decoded: a box with holes would flash. */
export async function loadFaces(api: Api, scan: string, viewpoint: string): Promise<HTMLImageElement[]> {
  const faces = [0, 1, 2, 3, 4, 5].map((face) => make('img', { src: api.face(scan, viewpoint, 'colour', face), alt: '' }));
  await Promise.all(faces.map((face) => face.decode()));
  return faces;
}
