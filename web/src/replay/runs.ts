/** Runs of the arena as the server tells them (/api/v1/openapi.json), and their steps in words. */

export interface Run {
  /** The name of its folder. */
  readonly run: string;
  // null: not known.
  readonly task: string | null;
  readonly split: string | null;
  readonly model: string | null;
  readonly prompt: string | null;
  /** That are done. */
  readonly episodes: number;
  readonly problem?: string;
}

export type Ending = 'stopped' | 'out-of-steps' | 'mistakes' | 'refused';

export interface Done {
  readonly ending: Ending;
  readonly steps: number;
  readonly mistakes: number;
}

/** An entry of a run's list: how an episode ended, or why that is not known. */
export type ListedEpisode = { readonly episode: string } & (Done | { readonly problem: string });

/** What a session tells at a step; degrees and metres. */
export interface Observation {
  /** Absent in replays, which say it once. */
  readonly instruction?: string;
  readonly step: number;
  readonly heading: number;
  readonly elevation: number;
  /** Absent in continuous space. */
  readonly here?: string;
  readonly places?: readonly Place[];
  readonly things?: readonly Thing[];
  readonly map?: readonly { readonly name: string; readonly leads_to: readonly string[] }[];
  readonly told: string;
  readonly tools: readonly ToolUse[];
}
export interface Place {
  readonly name: string;
  /** To the right, from where one looks. */
  readonly turn: number;
  readonly elevation: number;
  readonly distance: number;
  readonly visited: boolean;
  readonly seen_before: boolean;
  readonly what?: string;
}
interface Thing {
  readonly name: string;
  readonly category: string;
  readonly turn: number;
  readonly elevation: number;
}
export interface ToolUse {
  readonly tool: string;
  readonly argument?: string;
  readonly allowed?: readonly string[];
  readonly list?: boolean;
}
export interface Call {
  readonly tool: string;
  readonly argument: string;
}

/** Where a step stood and looked, degrees. */
export interface At {
  readonly viewpoint: string;
  readonly heading: number;
  readonly elevation: number;
  /** Viewpoints that the call before walked through. */
  readonly path: readonly string[];
  /** Viewpoints of places, by name. */
  readonly places: Readonly<Record<string, string>>;
}
export interface Step {
  readonly observation: Observation;
  readonly call: Call | null;
  readonly told: string;
  readonly text?: string;
  readonly prompt_tokens?: number;
  readonly answer_tokens?: number;
  readonly at?: At;
}
export interface Replay extends Omit<Run, 'episodes'> {
  readonly episode: string;
  readonly instruction: string;
  readonly scan: string | null;
  readonly steps: readonly Step[];
  readonly end: Done & { readonly at?: At };
  readonly place_problem?: string;
}

/** "go_to B"; "no call" where none could be read. */
export const callText = (call: Call | null): string => (call ? `${call.tool} ${call.argument}`.trim() : 'no call');

const endings: Record<Ending, string> = {
  stopped: 'stopped', 'out-of-steps': 'ran out of steps', mistakes: 'made too many mistakes one after another',
  refused: 'was broken off by the server',
};
const counted = (n: number, one: string): string => `${n} ${one}${n === 1 ? '' : 's'}`;

/** "stopped after 5 steps, 1 mistake" */
export const endText = ({ ending, steps, mistakes }: Done): string =>
  `${endings[ending] ?? ending} after ${counted(steps, 'step')}, ${mistakes === 0 ? 'no mistake' : counted(mistakes, 'mistake')}`;

/** "ahead", "30° to the right", "behind". @param turn degrees, to the right */
export function turnText(turn: number): string {
  const degrees = Math.round(turn);
  if (degrees === 0) return 'ahead';
  if (Math.abs(degrees) === 180) return 'behind';
  return `${Math.abs(degrees)}° to the ${degrees > 0 ? 'right' : 'left'}`;
}

/** "30° to the right, 12° up, 2.3 m": where a place lies from where one looks. */
export function placeText({ turn, elevation, distance }: Place): string {
  const up = Math.round(elevation);
  return [turnText(turn), ...(up === 0 ? [] : [`${Math.abs(up)}° ${up > 0 ? 'up' : 'down'}`]), `${distance.toFixed(1)} m`].join(', ');
}

/** The step number of an address: "#3", from 1 up to the number of steps. */
export function parseStep(hash: string, most: number): number {
  const number = /^#?(\d{1,6})$/.exec(hash)?.[1];
  return Math.min(Math.max(Number(number ?? 1), 1), most);
}
