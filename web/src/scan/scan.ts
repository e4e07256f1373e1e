/** What the server tells of a scan, and asking for it. Shapes: /api/v1/openapi.json. */
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

export interface Storey {
  readonly floor: number;
  readonly viewpoints: readonly number[];
}

export interface Scan {
  readonly scan: string;
  readonly synthetic: boolean;
  /** Whether the server has runs to look at: /replay. */
  readonly runs?: boolean;
  /** Whether one can walk freely in it: /roam. */
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

/** A word of an instruction that was spoken; seconds since the recording began. */
export interface TimedWord {
  readonly word: string;
  readonly start?: number;
  readonly end?: number;
}

/** What one of two people said, after so many steps. */
export interface Turn {
  readonly role: string;
  readonly message: string;
  readonly nav_step: number;
}

/** A piece of an instruction, and the places of the path that it describes, 0-based. */
export interface Part {
  readonly words: readonly string[];
  readonly places?: readonly [number, number];
}

/** What an episode asks for, other than to end where its path does. */
export interface Goal {
  readonly kind: 'end' | 'turning_point' | 'object' | 'region' | 'boxes';
  /** What is there: "plant". */
  readonly name?: string;
  readonly object?: number;
  /** Ids: who sees the object, what the region has, where one turns. */
  readonly viewpoints?: readonly string[];
  /** Closed lines around the object: headings and elevations in turn, radians. */
  readonly outlines?: readonly { readonly viewpoint: string; readonly label: string; readonly rim: readonly number[] }[];
}

/** How somebody looked while speaking: lists of one length, in the order of time. */
export interface Trace {
  /** Seconds. */
  readonly times: readonly number[];
  /** Ids. */
  readonly viewpoints: readonly string[];
  /** Radians. */
  readonly headings: readonly number[];
  readonly elevations: readonly number[];
}

export interface Episode {
  readonly instruction_id: string;
  readonly path_id: number;
  readonly scan: string;
  readonly heading: number;
  readonly instruction: string;
  readonly start: string;
  /** Absent where goals are hidden. */
  readonly path?: readonly string[];
  readonly distance?: number;
  /** BCP 47, where the file says it. */
  readonly language?: string;
  // Of an episode that was asked for by its id, as far as there is any.
  readonly task?: string;
  readonly turns?: readonly Turn[];
  readonly words?: readonly TimedWord[];
  readonly parts?: readonly Part[];
  readonly fields?: Readonly<Record<string, string>>;
  readonly goal?: Goal;
  readonly trace?: Trace;
  /** Why there is none, where its file is broken. */
  readonly trace_problem?: string;
}

export interface Problem {
  readonly severity: 'note' | 'warning' | 'error';
  readonly where: string;
  readonly code: string;
  readonly message: string;
}

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
  readonly depth: { readonly farthest: number; readonly colours: readonly string[] } | null;
  readonly classes: readonly { readonly name: string; readonly colour: string; readonly share: number }[] | null;
}

/** What a server answers that does not do what was asked. */
export class ServerError extends Error {
  readonly status: number;
  readonly code: string;
  readonly problems: readonly Problem[];

  constructor(status: number, code: string, message: string, problems: readonly Problem[] = []) {
    super(message);
    this.status = status;
    this.code = code;
    this.problems = problems;
  }
}

/** A server's API. `base` is its address, "" for the one that the page is from. */
export class Api {
  readonly base: string;

  constructor(base = '') {
    this.base = base.replace(/\/$/, '');
  }

  /** Throws ServerError, or TypeError if the server can't be reached. */
  async call<T>(path: string, init: RequestInit = {}): Promise<T> {
    const response = await fetch(`${this.base}/api/v1/${path}`, {
      ...init,
      // Tells the server that the request is a script's of its own pages: other sites can't.
      headers: { 'X-Enfilade': '1', ...init.headers },
    });
    const answer: unknown = await response.json().catch(() => undefined);
    if (response.ok) return answer as T;
    const error = (answer as { error?: { code: string; message: string; diagnostics?: Problem[] } })
      ?.error;
    throw new ServerError(
      response.status,
      error?.code ?? 'no-answer',
      error?.message ?? `the server answered with status ${response.status}`,
      error?.diagnostics,
    );
  }

  scan(scan: string): Promise<Scan> {
    return this.call(`scans/${encodeURIComponent(scan)}`);
  }

  plan(scan: string): Promise<Plan> {
    return this.call(`scans/${encodeURIComponent(scan)}/plan`);
  }

  legends(scan: string, viewpoint: string): Promise<Legends> {
    return this.call(`${this.viewpoint(scan, viewpoint)}/legends`);
  }

  /** How far it is from a viewpoint, as Surround.parse() reads it. */
  async distances(scan: string, viewpoint: string): Promise<ArrayBuffer> {
    const response = await fetch(`${this.base}/api/v1/${this.viewpoint(scan, viewpoint)}/distances`);
    if (!response.ok) throw new Error(`no distances of viewpoint ${viewpoint}`);
    return response.arrayBuffer();
  }

  private viewpoint(scan: string, viewpoint: string): string {
    return `scans/${encodeURIComponent(scan)}/viewpoints/${encodeURIComponent(viewpoint)}`;
  }

  /** The address of a face's picture, 0 up, 1 back, 2 left, 3 front, 4 right, 5 down. */
  face(scan: string, viewpoint: string, layer: Layer, face: number): string {
    const [folder, suffix] = {
      colour: ['faces', 'jpg'],
      depth: ['depth', 'png'],
      class: ['classes', 'png'],
    }[layer] as [string, string];
    return `${this.base}/api/v1/${this.viewpoint(scan, viewpoint)}/${folder}/${face}.${suffix}`;
  }
}
