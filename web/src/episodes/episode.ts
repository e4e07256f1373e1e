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

/** One of several instructions of a path. */
export interface PathInstruction {
  readonly instruction_id: string;
  readonly instruction: string;
  /** BCP 47 */
  readonly language?: string;
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
  /** All of its path, its own among them, in the order of the file. */
  readonly instructions?: readonly PathInstruction[];
  /** Its place among those that the list's words and building leave, from 1, and how many those are. */
  readonly number?: number;
  readonly of?: number;
  /** Ids of its neighbours there. */
  readonly previous?: string;
  readonly next?: string;
  readonly goal?: Goal;
  readonly trace?: Trace;
  /** Why there is none, where its file is broken. */
  readonly trace_problem?: string;
  readonly parts_problem?: string;
}

/** "Hindi (India)", or the code where the browser has no name for it. */
export function languageName(code: string): string {
  try {
    return new Intl.DisplayNames('en', { type: 'language' }).of(code) ?? code;
  } catch {
    return code; // no well-formed code
  }
}

const turnNames: Readonly<Record<string, string>> = { NAV: 'Navigator', ORA: 'Oracle', TAR: 'Looking for' };

/**
 * An instruction as people read it, with line breaks: CVDN's tags become words, and R4R's texts, which are joined without a blank, stand apart.
 * @param task "cvdn"
 */
export function shownText(text: string, task: string | null | undefined): string {
  switch (task) {
    case 'cvdn': return text.replace(/\s*<(NAV|ORA|TAR)>/g, (_, tag: string) => `\n${turnNames[tag]}:`).trim();
    case 'r4r': return text.replace(/([\p{L}\d)][.!?]+["')]*|[\p{Ll}\d,;)])(?=\p{Lu}(?:\p{Ll}|\s))/gu, '$1\n');
    default: return text;
  }
}
