/** A fly-through as a function of time: where the eye is, between which viewpoints, and how it looks. */
import {
  type Direction,
  directionTo,
  norm,
  subtract,
  wrapDifference,
  wrapHeading,
} from '../geometry/geometry.ts';
import type { Scan } from '../scan/scan.ts';

/** Radians and metres in a second, at speed 1: a walk, not a rush. */
const turnSpeed = Math.PI / 2;
const walkSpeed = 1.2;
/** One looks around at the start and at the goal for so long. */
const pause = 0.8;

/** A moment of a flight. */
export interface Moment extends Direction {
  readonly from: number;
  readonly to: number;
  /** Of the way from `from` to `to`. */
  readonly share: number;
}

/** Where one is in the course of time. */
export interface Timeline {
  readonly seconds: number;
  /** The moment at a time in seconds; before 0 and beyond `seconds` the first or last. */
  at(seconds: number): Moment;
}

interface Leg {
  readonly seconds: number;
  at(share: number): Moment;
}

const smooth = (t: number): number => t * t * (3 - 2 * t);

/** Along a path of viewpoints, each next to the one before. */
export class Flight implements Timeline {
  readonly seconds: number;
  private readonly legs: Leg[] = [];

  constructor(scan: Scan, path: readonly number[], start: Direction) {
    let heading = start.heading;
    let elevation = start.elevation;
    this.stay(path[0]!, heading, elevation);
    for (let k = 0; k + 1 < path.length; ++k) {
      const [from, to] = [path[k]!, path[k + 1]!];
      const [a, b] = [scan.viewpoints[from]!.position, scan.viewpoints[to]!.position];
      const towards = directionTo(a, b).heading; // level: one looks ahead, not at the floor
      this.turn(from, heading, elevation, towards, 0);
      [heading, elevation] = [towards, 0];
      this.legs.push({
        seconds: norm(subtract(b, a)) / walkSpeed,
        at: (share) => ({ from, to, share: smooth(share), heading: towards, elevation: 0 }),
      });
    }
    this.stay(path.at(-1)!, heading, elevation);
    this.seconds = this.legs.reduce((sum, leg) => sum + leg.seconds, 0);
  }

  /** The moment at a time in seconds, from 0 to `seconds`; beyond, the first or last. */
  at(seconds: number): Moment {
    let left = Math.max(seconds, 0);
    for (const leg of this.legs) {
      if (left < leg.seconds) return leg.at(left / leg.seconds);
      left -= leg.seconds;
    }
    return this.legs.at(-1)!.at(1);
  }

  private stay(at: number, heading: number, elevation: number): void {
    this.legs.push({
      seconds: pause,
      at: () => ({ from: at, to: at, share: 0, heading, elevation }),
    });
  }

  private turn(at: number, heading: number, elevation: number, towards: number, to: number): void {
    const [dh, de] = [wrapDifference(towards - heading), to - elevation];
    const seconds = Math.max(Math.abs(dh), Math.abs(de)) / turnSpeed;
    if (seconds < 1e-3) return;
    this.legs.push({
      seconds,
      at: (share) => ({
        from: at,
        to: at,
        share: 0,
        heading: wrapHeading(heading + dh * smooth(share)),
        elevation: elevation + de * smooth(share),
      }),
    });
  }
}
