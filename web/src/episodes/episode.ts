/** An episode of a benchmark as the server sends it. Shapes: /api/v1/openapi.json. */

/** A word of an instruction that was spoken; seconds since the recording began. */
export interface TimedWord {
  readonly word: string;
  readonly start?: number;
  readonly end?: number;
}

/** What one of two people said, and the number of steps before it. */
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

/** A guide's viewpoints and views while speaking: lists of one length, in the order of time. */
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
