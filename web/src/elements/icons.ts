/** Drawings of a line or two, made as elements: our content policy allows no markup in scripts. */

import { shape } from './svg.ts';

/** Paths of a drawing, 48 x 48: in ink, with the accent, filled with it. */
interface Drawing {
  readonly ink: string;
  readonly tint?: string;
  readonly fill?: readonly (readonly [number, number, number])[];
}

const drawings = {
  // Doors one behind the other, and the floor.
  explore: { ink: 'M6 44V4h36v40M14 44V13h20v31', tint: 'M20 44V22h8v22' },
  // Lines of writing, and the path that they describe.
  write: { ink: 'M6 8h24M6 16h17M6 24h9', tint: 'M10 42C14 30 24 40 29 31S34 22 42 20', fill: [[10, 42, 3], [42, 20, 3]] },
  // Rings on the floor that become smaller.
  walk: { ink: 'M3 40a11 4 0 1 0 22 0a11 4 0 1 0-22 0M20 27a8 2.8 0 1 0 16 0a8 2.8 0 1 0-16 0', tint: 'M40 16V3l6 3-6 3', fill: [[40, 17, 2.5]] },
  // What is said, and a letter that stands for a place.
  play: { ink: 'M4 6h40v28H22l-9 9v-9H4Z', tint: 'M18 28l6-15 6 15M20 23h8' },
  // Steps, done and to come.
  runs: { ink: 'M18 10h26M18 24h26M18 38h26', tint: 'M4 10l3 3 6-6M4 24l3 3 6-6', fill: [[8, 38, 3]] },
  // Bars with intervals.
  compete: { ink: 'M4 44h40M8 44V30h8v14M20 44V20h8v24', tint: 'M32 44V11h8v33M36 16V5M33.5 5h5M33.5 16h5' },
} as const satisfies Record<string, Drawing>;

export type IconName = keyof typeof drawings;

export function icon(name: IconName): SVGElement {
  const { ink, tint, fill = [] }: Drawing = drawings[name];
  return shape('svg', { viewBox: '0 0 48 48', 'aria-hidden': 'true' }, shape('path', { d: ink }),
    ...(tint ? [shape('path', { d: tint, class: 'tint' })] : []),
    ...fill.map(([cx, cy, r]) => shape('circle', { cx, cy, r, class: 'fill' })));
}
