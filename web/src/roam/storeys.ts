/** Which storey a height belongs to. */

/** Metres that a storey's floor may lie above what belongs to it: steps, sunken rooms. */
const below = 0.8;
/** Of doll's houses: walls are cut so high above the floor, metres. */
const cut = 1.9;

/** The highest storey whose floor is not above. @param floors ascending, world z */
export function storeyAt(floors: readonly number[], z: number): number {
  let storey = 0;
  floors.forEach((floor, k) => {
    if (floor <= z + below) storey = k;
  });
  return storey;
}

/** Where a doll's house that shows a storey is cut, world z. */
export const ceilingOf = (floors: readonly number[], storey: number): number => (floors[storey] ?? 0) + cut;
