import { describe, expect, it } from 'vitest';
import { random } from '../testing/random.ts';
import { Floor, type FloorData } from './floor.ts';
import { Walker } from './walker.ts';

const walker = { eye: 1.25, forward: 0.25, turn: Math.PI / 12, look: Math.PI / 6, most_elevation: Math.PI / 3 };
const body = { radius: 0.1, height: 1.5, step: 0.2 };

type Quad = readonly [x0: number, y0: number, x1: number, y1: number];

/** Rectangles of a floor, counter-clockwise; those that share a whole side are neighbours. Height is a function of the place. */
function floorOf(quads: readonly Quad[], height: (x: number, y: number) => number = () => 0, clockwise = false): FloorData {
  const rings = quads.map(([x0, y0, x1, y1]) => {
    const ring = [[x0, y0], [x1, y0], [x1, y1], [x0, y1]] as [number, number][];
    return clockwise ? ring.reverse() : ring;
  });
  const same = (a: readonly number[], b: readonly number[]) => a[0] === b[0] && a[1] === b[1];
  return {
    scan: 's', body, walker,
    polygons: rings.map((ring, p) => ({
      area: 0,
      beyond: ring.map((a, k) => {
        const b = ring[(k + 1) % 4]!;
        return rings.findIndex((other, q) => q !== p && other.some((c, m) => same(c, b) && same(other[(m + 1) % 4]!, a)));
      }),
      points: ring.flatMap(([x, y]) => [x, y, height(x, y)]),
      triangles: [0, 1, 2, 0, 2, 3],
    })),
  };
}

/** An L of two rooms: 4 x 2 m, and 2 x 3 m on its right half. */
const angle = floorOf([[0, 0, 2, 2], [2, 0, 4, 2], [2, 2, 4, 5]]);
const at = (floor: Floor, x: number, y: number, z = 0) => floor.nearest([x, y, z])!;

describe.each([['counter-clockwise', false], ['clockwise', true]])('a floor with corners %s', (_, clockwise) => {
  const floor = new Floor(floorOf([[0, 0, 2, 2], [2, 0, 4, 2], [2, 2, 4, 5]], undefined, clockwise));

  it('is walked straight over, from one polygon into the next', () => {
    const { end, atWall } = floor.walk(at(floor, 1.5, 1), 1, 0.5);
    expect(end).toEqual({ position: [2.5, 1.5, 0], polygon: 1 });
    expect(atWall).toBe(false);
  });

  it('ends at a wall that one walks straight into', () => {
    const { end, atWall } = floor.walk(at(floor, 1, 1.9), 0, 0.25);
    expect(end.position[0]).toBeCloseTo(1, 12);
    expect(end.position[1]).toBeCloseTo(2, 12);
    expect(atWall).toBe(true);
  });

  it('lets one slide along a wall: what is across it is lost, what is along it is kept', () => {
    const { end, atWall } = floor.walk(at(floor, 1, 1.9), 0.2, 0.15);
    expect(end.position[0]).toBeCloseTo(1.2, 12);
    expect(end.position[1]).toBeCloseTo(2, 12);
    expect(atWall).toBe(true);
  });

  it('lets one slide round a corner that is not far from the line', () => {
    // It would end at (1.95, 2.1), in the wall: the left side of the upper room is 0.05 m away, the top of the first one 0.1 m.
    const { end, atWall } = floor.walk(at(floor, 1.9, 1.95), 0.05, 0.15);
    expect(end.polygon).toBe(2);
    expect(end.position[0]).toBeCloseTo(2, 12);
    expect(end.position[1]).toBeCloseTo(2.1, 12);
    expect(atWall).toBe(true);
  });

  it('is seen straight ahead as far as the first wall', () => {
    const { end, metres } = floor.ahead(at(floor, 0.5, 1), 1, 0, 10);
    expect(metres).toBeCloseTo(3.5, 12);
    expect(end).toEqual({ position: [4, 1, 0], polygon: 1 });
    expect(floor.ahead(at(floor, 0.5, 1), 1, 0, 2).end).toEqual({ position: [2.5, 1, 0], polygon: 1 });
    expect(floor.ahead(at(floor, 1, 1), 0, 1, 10).metres).toBeCloseTo(1, 12); // no sliding
    expect(floor.ahead(at(floor, 3, 0.5), 0, 1, 10)).toMatchObject({ metres: 4.5, end: { polygon: 2 } });
    expect(floor.ahead(at(floor, 4, 1), 1, 0, 10).metres).toBeCloseTo(0, 12); // it stands at the wall
    expect(floor.ahead(at(floor, 4, 1), -1, 0, 10).metres).toBeCloseTo(4, 12);
  });

  it('has a heading in which there is most of it', () => {
    expect(Math.abs(floor.openHeading(at(floor, 0.5, 1)) - Math.PI / 2)).toBeLessThan(0.2);
    expect(Math.abs(floor.openHeading(at(floor, 3, 4.5)) - Math.PI)).toBeLessThan(0.2);
  });

  it('has the nearest point to one that is beside it', () => {
    expect(at(floor, 1, 3)).toMatchObject({ position: [1, 2, 0], polygon: 0 });
    expect(at(floor, 5, 6).position).toEqual([4, 5, 0]);
  });

  it('has a rim around all of it, and nowhere inside', () => {
    let length = 0;
    for (const [ax, ay, bx, by] of floor.rim()) length += Math.hypot(bx - ax, by - ay);
    expect(length).toBeCloseTo(2 * (4 + 5)); // an L has the length around of its box
  });
});

describe('a walk', () => {
  it('never leaves the floor, and never ends farther from where it should than it began', () => {
    const floor = new Floor(angle);
    const next = random(1);
    let here = at(floor, 1, 1);
    let walls = 0;
    for (let k = 0; k < 20_000; ++k) {
      const heading = 2 * Math.PI * next();
      const [dx, dy] = [0.25 * Math.sin(heading), 0.25 * Math.cos(heading)];
      const { end, atWall } = floor.walk(here, dx, dy);
      const [x, y] = end.position;
      const inL = x >= -1e-9 && x <= 4 + 1e-9 && y >= -1e-9 && (y <= 2 + 1e-9 || (x >= 2 - 1e-9 && y <= 5 + 1e-9));
      expect(inL, `${x}, ${y}`).toBe(true);
      expect(floor.contains(end.polygon, x, y)).toBe(true);
      expect(Math.hypot(x - here.position[0] - dx, y - here.position[1] - dy)).toBeLessThanOrEqual(0.25 + 1e-9);
      walls += atWall ? 1 : 0;
      here = end;
    }
    expect(walls).toBeGreaterThan(100);
  });

  it('comes as far straight ahead as by small steps, from anywhere', () => {
    const floor = new Floor(angle);
    const next = random(1);
    for (let k = 0; k < 300; ++k) {
      const heading = 2 * Math.PI * next();
      const start = at(floor, 4 * next(), 5 * next());
      const [dx, dy] = [Math.sin(heading), Math.cos(heading)];
      const { metres, end } = floor.ahead(start, dx, dy, 6);
      let [here, walked] = [start, 0];
      for (;;) {
        const { end: there, atWall } = floor.walk(here, 0.01 * dx, 0.01 * dy);
        if (atWall) break;
        [here, walked] = [there, walked + 0.01];
      }
      expect(Math.abs(metres - walked)).toBeLessThan(0.011);
      expect(floor.nearest(end.position)!.position[0]).toBeCloseTo(end.position[0], 6);
    }
  });

  it('is as open in all directions from the middle of a room: then people look where they looked', () => {
    const room = new Floor(floorOf([[0, 0, 4, 4]]));
    for (const heading of [0, Math.PI / 2, Math.PI]) {
      expect(Math.cos(room.openHeading(at(room, 2, 2), heading) - heading)).toBeGreaterThan(0.6);
    }
  });

  it('goes up and down with the floor', () => {
    const slope = new Floor(floorOf([[0, 0, 2, 2], [2, 0, 4, 2]], (x) => 0.3 * x));
    const { end } = slope.walk(at(slope, 0.5, 1, 0.15), 2.1, 0.3);
    expect(end.position[2]).toBeCloseTo(0.3 * 2.6, 12);
    expect(slope.height(1, 3.3, 0.7)).toBeCloseTo(0.99, 12);
    // Beside the polygon, where rounding can put a point of its rim, the height of the nearest edge.
    expect(slope.height(0, -1e-7, 1)).toBeCloseTo(0, 6);
  });

  it('does not come through to the storey above', () => {
    const two = new Floor({ ...angle, polygons: [...angle.polygons, ...floorOf([[0, 0, 4, 2]], () => 2.7).polygons] });
    expect(two.nearest([1, 1, 2.5])!.polygon).toBe(3);
    expect(two.nearest([1, 1, 0.5])!.polygon).toBe(0);
    expect(two.hit([1, 1, 9], [0, 0, -1], 4)!.position[2]).toBe(2.7);
    expect(two.hit([1, 1, 9], [0, 0, -1], 2)!.position[2]).toBe(0);
    expect(two.hit([9, 9, 9], [0, 0, -1], 4)).toBeUndefined();
  });
});

describe('a walker', () => {
  const started = (heading = 0) => {
    const floor = new Floor(angle);
    return new Walker(floor, at(floor, 1, 1), { heading, elevation: 0 });
  };

  it('turns 24 times by 15 degrees, and looks exactly as before', () => {
    const one = started(0.7);
    for (let k = 0; k < 24; ++k) one.act('right');
    expect(one.heading).toBe(0.7);
    one.act('left');
    expect(one.heading).toBeCloseTo(0.7 - Math.PI / 12, 12);
    expect(one.actions).toBe(25);
  });

  it('steps where it looks: 0 is +y, and headings run clockwise', () => {
    const one = started();
    expect(one.act('forward')).toBe(false);
    expect(one.position).toEqual([1, 1.25, 0]);
    for (let k = 0; k < 6; ++k) one.act('right');
    one.act('forward');
    expect(one.position[0]).toBeCloseTo(1.25, 12);
    expect(one.eye[2]).toBe(1.25);
    expect(one.length).toBeCloseTo(0.5, 12);
    expect(one.trail).toHaveLength(3);
  });

  it('counts the steps that a wall cut short', () => {
    const one = started();
    const touched = Array.from({ length: 6 }, () => one.act('forward'));
    expect(touched).toEqual([false, false, false, false, true, true]); // it stands at y = 2 after four
    expect(one.collisions).toBe(2);
    expect(one.position[1]).toBeCloseTo(2, 12);
  });

  it('walks smoothly ahead and aside, and looks no higher than it can', () => {
    const one = started(Math.PI / 2);
    one.glide(0.3, 0.1);
    expect(one.position[0]).toBeCloseTo(1.3, 12);
    expect(one.position[1]).toBeCloseTo(0.9, 12);
    expect(one.collisions).toBe(0);
    one.look(1, 9);
    expect(one.elevation).toBeCloseTo(Math.PI / 3);
    expect(one.heading).toBeCloseTo(1, 12);
    one.act('right');
    expect(one.heading).toBeCloseTo(1 + Math.PI / 12, 12);
  });

  it('tells of each change, and forgets its walk where it is put', () => {
    const one = started();
    let told = 0;
    one.onChange(() => ++told);
    one.act('forward');
    one.place(at(one.floor, 3, 4), { heading: 2, elevation: 0 });
    expect(told).toBeGreaterThanOrEqual(2);
    expect([one.length, one.actions, one.trail.length]).toEqual([0, 0, 1]);
    expect(one.position).toEqual([3, 4, 0]);
  });
});
