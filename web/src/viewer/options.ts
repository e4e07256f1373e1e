/** How a viewer is opened, and what is seen and done in it. */
import { degrees, type Direction } from '../geometry/geometry.ts';
import { halfFieldOfView } from '../scan/navigation.ts';

export interface ViewerOptions extends Partial<Direction> {
  readonly scan: string;
  /** An id; absent: the first viewpoint that has pictures. */
  readonly viewpoint?: string;
  /** An id: looks there first, if no heading is given. Absent: to where most is to be seen. */
  readonly towards?: string;
  /** Absent: what suits the picture's shape, until one zooms. */
  readonly vfov?: number;
  /** The server's address; absent: that of the page. */
  readonly server?: string;
  /** Absent: one may look and go everywhere. */
  readonly rules?: Rules;
}

/** What one may see and do, where that is less than everything. */
export interface Rules {
  /** Radians: only steps that lie within this angle of the heading can be taken. */
  readonly within: number;
  /** One looks so far up and down at most, radians. */
  readonly mostElevation: number;
  /** The vertical opening, which stays, radians. */
  readonly vfov: number;
  /** Width of the picture divided by its height. */
  readonly aspect: number;
}

/** What an agent of R2R sees: 640 x 480 at 60 degrees, three rows of views, MatterSim's linear field of view. */
export const agentRules: Rules = {
  within: halfFieldOfView({ width: 640, height: 480, vfov: degrees(60) }),
  mostElevation: degrees(30),
  vfov: degrees(60),
  aspect: 640 / 480,
};
