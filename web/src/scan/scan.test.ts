import { describe, expect, it } from 'vitest';
import { worldFromCamera } from '../geometry/geometry.ts';
import { namesByViewpoint, pictured, type Room, roomCentre, type Scan } from './scan.ts';

const rotation = worldFromCamera({ heading: 0, elevation: 0 });
/** A row to the east, 1 m apart; the one in the middle has no pictures. */
const scan: Scan = {
  scan: 's', synthetic: true, storeys: [],
  viewpoints: [0, 1, 2].map((x) => ({
    id: `v${x}`, included: true, position: [x, 0, 1.5], height: 1.5, neighbours: [], layers: [], ...(x !== 1 && { rotation }),
  })),
};
const room = (name: string, viewpoints: readonly number[]): Room =>
  ({ name, storey: 0, floor: 0, outline: [-0.5, -1, 2.7, -1, 2.7, 1, -0.5, 1], viewpoints });

describe('rooms', () => {
  it('have a viewpoint nearest to their middle, and one with pictures', () => {
    const hall = room('hall', [0, 1, 2]);
    expect(roomCentre(scan, hall)).toBe(1);
    expect(pictured(scan, hall)).toEqual(room('hall', [0, 2]));
    expect(roomCentre(scan, pictured(scan, hall))).toBe(2);
    expect(pictured(scan, room('closet', [1])).viewpoints).toEqual([]);
  });

  it('give viewpoints their names, where they have one', () => {
    expect(namesByViewpoint({ storeys: [], rooms: [room('hall', [0, 1]), room('', [2])] })).toEqual(new Map([[0, 'hall'], [1, 'hall']]));
  });
});
