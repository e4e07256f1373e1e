/** A scan as the server sends it. Shapes: /api/v1/openapi.json. */
import type { Mat3, Vec3 } from '../geometry/geometry.ts';

export type Layer = 'colour' | 'depth' | 'class';

export interface Viewpoint {
  readonly id: string;
  readonly included: boolean;
  /** Metres, world frame. */
  readonly position: Vec3;
  /** Above the floor, metres; 0 if unknown. */
  readonly height: number;
  /** Indices into Scan.viewpoints. */
  readonly neighbours: readonly number[];
  readonly layers: readonly Layer[];
  /** World from panorama; absent where there are no pictures. */
  readonly rotation?: Mat3;
}

interface Storey {
  readonly floor: number;
  readonly viewpoints: readonly number[];
}

export interface Scan {
  readonly scan: string;
  readonly synthetic: boolean;
  /** Whether the server has runs to look at: /replay. */
  readonly runs?: boolean;
  /** Whether it has a navigation mesh to walk on: /roam. */
  readonly roam?: boolean;
  readonly storeys: readonly Storey[];
  readonly viewpoints: readonly Viewpoint[];
}

/** The index of the viewpoint with that id; -1 if the scan has none. */
export const viewpointIndex = (scan: Scan, id: string | undefined): number =>
  scan.viewpoints.findIndex((viewpoint) => viewpoint.id === id);

/** The index of the storey that a viewpoint is in; -1 if none has it. */
export const storeyOf = (scan: Scan, viewpoint: number): number =>
  scan.storeys.findIndex(({ viewpoints }) => viewpoints.includes(viewpoint));

/** Lines of a plan: four numbers each, x and y of start and end, metres. */
export type Lines = readonly number[];

export interface PlanStorey {
  /** Metres, world z. */
  readonly floor: number;
  readonly walls: Lines;
  readonly doors: Lines;
  readonly windows: Lines;
  readonly stairs: Lines;
  readonly furniture: Lines;
}

export interface Room {
  /** May be empty. */
  readonly name: string;
  /** Index into Scan.storeys. */
  readonly storey: number;
  /** Metres, world z. */
  readonly floor: number;
  /** Of its walls, metres; absent if unknown. */
  readonly height?: number;
  /** Corners in order, x and y in turn. */
  readonly outline: readonly number[];
  /** Indices into Scan.viewpoints. */
  readonly viewpoints: readonly number[];
}

/** Rooms and walls as far as they are known; of most scans nothing is. */
export interface Plan {
  readonly storeys: readonly PlanStorey[];
  readonly rooms: readonly Room[];
}

/** The names of viewpoints' rooms, as far as they have one. */
export const namesByViewpoint = ({ rooms }: Plan): ReadonlyMap<number, string> =>
  new Map(rooms.flatMap(({ name, viewpoints }) => (name ? viewpoints.map((v) => [v, name] as const) : [])));

/** A room with those of its viewpoints only that have pictures: where one can go. */
export const pictured = (scan: Scan, room: Room): Room =>
  ({ ...room, viewpoints: room.viewpoints.filter((v) => scan.viewpoints[v]?.rotation) });

/** The viewpoint of a room that stands nearest to its middle. \pre it has one */
export function roomCentre(scan: Scan, room: Room): number {
  const mean = (which: number) => {
    const values = room.outline.filter((_, k) => k % 2 === which);
    return (Math.min(...values) + Math.max(...values)) / 2;
  };
  const [x, y] = [mean(0), mean(1)];
  const away = (v: number) => {
    const { position } = scan.viewpoints[v]!;
    return Math.hypot(position[0] - x, position[1] - y);
  };
  return room.viewpoints.reduce((best, v) => (away(v) < away(best) ? v : best));
}

/** What the colours of a viewpoint's depth and classes mean. */
export interface Legends {
  readonly depth: { readonly nearest: number; readonly farthest: number; readonly colours: readonly string[] } | null;
  readonly classes: readonly { readonly name: string; readonly colour: string; readonly share: number }[] | null;
}
