/** Where one looks at first, and on arrival: at what is open, a little down. Agents' views have rules of their own. */
import { type Camera, degrees, type Direction, directionTo, norm, subtract, wrapDifference, wrapHeading } from '../geometry/geometry.ts';
import { type Scan, viewpointIndex } from '../scan/scan.ts';
import { reachOf, type Surround } from './surround.ts';

/** Radians: floors show more of a room than ceilings do. */
export const usualElevation = degrees(-14);
/** Metres: what is nearer fills the picture. */
const tooNear = 1;
/** Metres: so far there is something to see. */
const clear = 2;

/** How far one can zoom, radians. */
export const limitVfov = (vfov: number): number => Math.min(Math.max(vfov, degrees(25)), degrees(110));

/** The vertical opening of a picture: 75 degrees, but 60 to 100 from side to side where the picture is tall or wide. */
export function usualVfov({ width, height }: Pick<Camera, 'width' | 'height'>): number {
  const ofWidth = (value: number) => 2 * Math.atan((Math.tan(degrees(value) / 2) * height) / width);
  return Math.min(Math.max(degrees(75), ofWidth(60)), ofWidth(100), degrees(100));
}

const headingTo = (scan: Scan, from: number, to: number): number =>
  directionTo(scan.viewpoints[from]!.position, scan.viewpoints[to]!.position).heading;

/** The heading in which most is to be seen. Without depth that of the farthest neighbour, and of none nothing. */
export function openHeading(scan: Scan, viewpoint: number, surround: Surround | undefined): number | undefined {
  const { position, rotation, neighbours } = scan.viewpoints[viewpoint]!;
  if (surround && rotation) {
    const positions = scan.viewpoints.map((one) => one.position);
    return surround.openHeading(rotation, neighbours.map((to) => headingTo(scan, viewpoint, to)),
      (heading) => reachOf(position, positions, heading));
  }
  const away = (to: number) => norm(subtract(scan.viewpoints[to]!.position, position));
  const farthest = [...neighbours].sort((a, b) => away(b) - away(a))[0];
  return farthest === undefined ? undefined : headingTo(scan, viewpoint, farthest);
}

interface Beginning extends Partial<Direction> {
  readonly viewpoint?: string;
  readonly towards?: string;
  readonly vfov?: number;
  /** The field of view of agents, whose first view is level; people look a little down. */
  readonly rules?: { readonly vfov: number };
}

/** What a scan has not: a viewpoint of an id, or any picture. */
export class NotInScan extends Error {}

/** The first pose: at the viewpoint, towards the other one or somewhere to go. Throws NotInScan. */
export function firstPose(scan: Scan, options: Beginning): Direction & { readonly viewpoint: number; readonly vfov: number } {
  const named = viewpointIndex(scan, options.viewpoint);
  if (options.viewpoint !== undefined && named < 0) throw new NotInScan(`${scan.scan} has no viewpoint "${options.viewpoint}"`);
  const viewpoint = named >= 0 ? named : scan.viewpoints.findIndex(({ included, rotation }) => included && rotation);
  if (viewpoint < 0) throw new NotInScan(`${scan.scan} has no pictures`);
  const towards = viewpointIndex(scan, options.towards);
  const next = towards >= 0 && towards !== viewpoint ? towards : scan.viewpoints[viewpoint]!.neighbours[0];
  return {
    viewpoint,
    heading: wrapHeading(options.heading ?? (next === undefined ? 0 : headingTo(scan, viewpoint, next))),
    elevation: options.elevation ?? (options.rules ? 0 : usualElevation),
    vfov: options.rules?.vfov ?? limitVfov(options.vfov ?? degrees(75)),
  };
}

interface Trip {
  readonly from: number;
  readonly to: number;
  /** Chosen on a map or in a list: not by going on. */
  readonly chosen: boolean;
  /** In which one looks before. */
  readonly look: Direction;
  /** The viewpoint that follows on a marked path. */
  readonly next: number | undefined;
  /** The distances around `to`. */
  readonly surround: Surround | undefined;
}

/**
 * Where one looks on arrival. After a step as before it, unless a wall is right ahead: then to the next of the path, to
 * the disc with the least turn that is no way back and behind which one sees far, or to where it is open. From elsewhere,
 * and to what was chosen, one arrives to the next of the path, or to where it is open.
 */
export function arrivalLook(scan: Scan, { from, to, chosen, look, next, surround }: Trip): Direction {
  const { rotation, neighbours } = scan.viewpoints[to]!;
  const isStep = !chosen && scan.viewpoints[from]!.neighbours.includes(to);
  const ahead = (heading: number) => (surround && rotation ? surround.ahead(rotation, heading) : Infinity);
  if (isStep && ahead(look.heading) >= tooNear) return look;
  const elevation = isStep ? look.elevation : usualElevation;
  const towards = (viewpoint: number) => headingTo(scan, to, viewpoint);
  if (next !== undefined) return { heading: towards(next), elevation };
  const turn = (heading: number) => Math.abs(wrapDifference(heading - look.heading));
  const ways = !isStep ? [] : neighbours.filter((viewpoint) => viewpoint !== from).map(towards)
    .filter((heading) => ahead(heading) >= clear).sort((a, b) => turn(a) - turn(b));
  return { heading: ways[0] ?? openHeading(scan, to, surround) ?? look.heading, elevation };
}

/** Where one looks at the end of a flight: to where it is open, if a wall is right ahead; nothing: as before. */
export function endLook(scan: Scan, viewpoint: number, heading: number, surround: Surround | undefined): Direction | undefined {
  const { rotation } = scan.viewpoints[viewpoint]!;
  if (!surround || !rotation || surround.ahead(rotation, heading) >= tooNear) return undefined;
  return { heading: openHeading(scan, viewpoint, surround) ?? heading, elevation: usualElevation };
}
