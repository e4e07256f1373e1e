import { describe, expect, it } from 'vitest';
import { degrees, toDegrees, worldFromCamera } from '../geometry/geometry.ts';
import type { Scan, Viewpoint } from '../scan/scan.ts';
import { arrivalLook, endLook, firstPose, limitVfov, NotInScan, openHeading, usualElevation, usualVfov } from './arrival.ts';
import { Surround } from './surround.ts';

const north = worldFromCamera({ heading: 0, elevation: 0 });
const at = (x: number, y: number, neighbours: number[]): Viewpoint => ({
  id: `${x},${y}`, included: true, position: [x, y, 1.5], height: 1.5, neighbours, layers: ['depth'], rotation: north,
});
/** A row to the north, whose second viewpoint has another one in the east, and one elsewhere. */
const scan: Scan = {
  scan: 's', synthetic: true, storeys: [],
  viewpoints: [at(0, 0, [1]), at(0, 2, [0, 2, 4]), at(3, 2, [1]), at(9, 9, []), at(-2, 2, [1])],
};

/** Faces 0 up, 1 back, 2 left, 3 front, 4 right, 5 down of 16 x 16 readings, metres. */
function around(metres: readonly number[]): Surround {
  const view = new DataView(new ArrayBuffer(6 * 256 * 2));
  for (let k = 0; k < 6 * 256; ++k) view.setUint16(k * 2, metres[Math.floor(k / 256)]! * 4000, true);
  return Surround.parse(view.buffer);
}

const look = { heading: 0, elevation: 0.1 };
const step = { from: 0, to: 1, chosen: false, look, next: undefined };
const headingOf = (trip: Parameters<typeof arrivalLook>[1]) => Math.round(toDegrees(arrivalLook(scan, trip).heading));

describe('on arrival one looks', () => {
  it('after a step as before, where something is to be seen', () => {
    expect(arrivalLook(scan, { ...step, surround: around([1, 4, 4, 1.2, 4, 1]) })).toEqual(look);
    expect(arrivalLook(scan, { ...step, surround: undefined })).toEqual(look);
  });

  it('after a step that ends at a wall where one can go on, and not back', () => {
    const surround = around([1, 9, 0.8, 0.5, 3, 1]); // open behind, where one came from, and to the right
    expect(arrivalLook(scan, { ...step, surround })).toEqual({ heading: degrees(90), elevation: 0.1 });
  });

  it('or where the path goes on', () => {
    expect(headingOf({ ...step, next: 4, surround: around([1, 9, 0.8, 0.5, 3, 1]) })).toBe(270);
  });

  it('or, at an end, where it is open', () => {
    const surround = around([1, 9, 0.8, 0.5, 0.8, 1]);
    expect(headingOf({ ...step, surround })).toBe(180);
  });

  it('from elsewhere where most is to be seen, and a little down', () => {
    const surround = around([1, 1, 1, 3, 6, 1]);
    const seen = arrivalLook(scan, { ...step, from: 3, look: { heading: 3, elevation: 1 }, surround });
    expect(Math.abs(toDegrees(seen.heading) - 90)).toBeLessThan(6);
    expect(seen.elevation).toBe(usualElevation);
    expect(headingOf({ ...step, from: 3, next: 4, surround }), 'on a path along it').toBe(270);
    expect(Math.abs(headingOf({ ...step, chosen: true, surround }) - 90), 'also one step away, if it was chosen on a map').toBeLessThan(6);
  });

  it('at the end of a flight as before, or where it is open if a wall is right ahead', () => {
    expect(endLook(scan, 1, 0, around([1, 9, 4, 1.2, 4, 1]))).toBeUndefined();
    expect(endLook(scan, 1, 0, undefined)).toBeUndefined();
    const seen = endLook(scan, 1, 0, around([1, 1, 1, 0.5, 6, 1]))!;
    expect(Math.abs(toDegrees(seen.heading) - 90)).toBeLessThan(6);
    expect(seen.elevation).toBe(usualElevation);
  });

  it('without depth along the longest edge', () => {
    expect(toDegrees(openHeading(scan, 1, undefined)!)).toBeCloseTo(90);
    expect(openHeading(scan, 3, undefined)).toBeUndefined();
  });
});

describe('the usual view', () => {
  const wide = (width: number, height: number) => {
    const vfov = usualVfov({ width, height });
    return [toDegrees(vfov), toDegrees(2 * Math.atan((Math.tan(vfov / 2) * width) / height))] as const;
  };
  it('is 75 degrees high, and neither narrow nor stretched from side to side', () => {
    expect(wide(1060, 846)[0]).toBeCloseTo(75);
    expect(wide(1060, 846)[1]).toBeGreaterThan(75);
    expect(wide(1060, 846)[1]).toBeLessThan(90);
    expect(wide(1920, 1080)[1]).toBeCloseTo(100);
    expect(wide(390, 380)[0]).toBeCloseTo(75);
    expect(wide(390, 844)[0]).toBeCloseTo(100);
    expect(wide(300, 400)[1]).toBeCloseTo(60);
  });
});

describe('the first pose', () => {
  it('of people looks a little down, that of agents is level and as wide as their rules say', () => {
    expect(firstPose(scan, {})).toMatchObject({ viewpoint: 0, elevation: usualElevation });
    expect(firstPose(scan, { rules: { vfov: 1 }, heading: 2 })).toEqual({ viewpoint: 0, heading: 2, elevation: 0, vfov: 1 });
    expect(firstPose(scan, { elevation: 0.3, vfov: 5 })).toMatchObject({ elevation: 0.3, vfov: degrees(110) });
    expect(toDegrees(limitVfov(0))).toBeCloseTo(25);
  });

  it('is towards a viewpoint, or somewhere to go', () => {
    expect(toDegrees(firstPose(scan, { viewpoint: '0,2', towards: '3,2' }).heading)).toBeCloseTo(90);
    expect(toDegrees(firstPose(scan, { viewpoint: '0,2' }).heading)).toBeCloseTo(180);
    expect(firstPose(scan, { viewpoint: '9,9' }).heading).toBe(0);
  });

  it('names what the scan has not', () => {
    expect(() => firstPose(scan, { viewpoint: 'nosuch' })).toThrow(new NotInScan('s has no viewpoint "nosuch"'));
    const bare = { ...scan, viewpoints: scan.viewpoints.map(({ rotation: _, ...rest }) => rest) };
    expect(() => firstPose(bare, {})).toThrow('s has no pictures');
  });
});
