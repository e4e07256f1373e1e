/** Addresses of views: `#scan/viewpoint/heading/elevation`, angles in degrees. */
import { degrees, toDegrees, type Direction, wrapHeading } from '../geometry/geometry.ts';

export interface Place extends Partial<Direction> {
  readonly scan: string;
  /** An id; absent: the scan's first. */
  readonly viewpoint?: string;
}

const angle = (text: string | undefined): number | undefined => {
  if (text === undefined || !/^-?\d+(\.\d+)?$/.test(text)) return undefined;
  return degrees(Number(text));
};

/** What a location.hash names; nothing if it names no scan. Parts that make no sense are left out. */
export function parseLink(hash: string): Place | undefined {
  let parts: string[];
  try {
    parts = hash.replace(/^#/, '').split('/').map(decodeURIComponent);
  } catch {
    return undefined; // half a %-code
  }
  const [scan, viewpoint] = parts;
  if (!scan) return undefined;
  const heading = angle(parts[2]);
  const elevation = angle(parts[3]);
  return {
    scan,
    ...(viewpoint && { viewpoint }),
    ...(heading !== undefined && { heading: wrapHeading(heading) }),
    ...(elevation !== undefined && {
      elevation: Math.min(Math.max(elevation, -Math.PI / 2), Math.PI / 2),
    }),
  };
}

/** Its inverse, to a tenth of a degree. */
export function formatLink(place: Place): string {
  const tenth = (radians: number) => String(Math.round(toDegrees(radians) * 10) / 10);
  // "@1.2,3,0", a point in the viewpoint's place, stays as it reads.
  const parts = [place.scan, place.viewpoint ?? ''].map((part) => encodeURIComponent(part).replaceAll('%40', '@').replaceAll('%2C', ','));
  if (place.heading !== undefined) parts.push(tenth(place.heading));
  if (place.elevation !== undefined) parts.push(tenth(place.elevation));
  return `#${parts.join('/')}`;
}
