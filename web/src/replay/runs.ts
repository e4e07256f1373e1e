/** Runs of the arena as the server tells them (/api/v1/openapi.json), and their steps in words. */
import { counted } from '../elements/page.ts';
import { type Outcome, ruleText } from '../episodes/outcome.ts';
import { splitKey } from '../episodes/splits.ts';

export interface Run {
  /** The name of its folder. */
  readonly run: string;
  // null: not known.
  readonly task: string | null;
  readonly split: string | null;
  readonly model: string | null;
  readonly prompt: string | null;
  /** Whether success is known: the server has the split's goals. */
  readonly outcomes: boolean;
  /** That are done. */
  readonly episodes: number;
  readonly problem?: string;
}

export type Ending = 'stopped' | 'out-of-steps' | 'mistakes' | 'refused';

export interface Done {
  readonly ending: Ending;
  /** Why an episode was refused, in the server's words. */
  readonly reason?: string;
  readonly steps: number;
  readonly mistakes: number;
}

/** Success as the benchmark's scorer has it; absent where it is not known. */
export interface Score {
  readonly success?: boolean;
  readonly spl?: number;
  /** Metres. */
  readonly nav_error?: number;
}

/** How an episode of a list ended. */
export interface EpisodeEnd extends Done, Score {
  /** Those mistakes that are responses without a call. */
  readonly unanswered: number;
  readonly prompt_tokens: number;
  readonly answer_tokens: number;
}
export interface Broken {
  /** What is wrong with the transcript. */
  readonly problem: string;
}
export type ListedEpisode = { readonly episode: string; readonly instruction?: string } & (EpisodeEnd | Broken);
export interface EpisodeList extends Run {
  /** As many as the filter lets through. */
  readonly matching: number;
  readonly list: readonly ListedEpisode[];
}

/** A measure of the benchmark's scorer. Shares are from 0 to 1. */
export interface Column {
  readonly name: string;
  /** "SR" */
  readonly short: string;
  readonly title: string;
  readonly unit: 'm' | 'share' | 'count';
  /** The better values; none where longer is neither better nor worse. */
  readonly better?: 'higher' | 'lower';
}
export interface Measures extends Run {
  readonly steps: number;
  readonly mistakes: number;
  readonly unanswered: number;
  readonly prompt_tokens: number;
  readonly answer_tokens: number;
  readonly seconds?: number;
  readonly money?: number;
  /** Episodes that the means are of. */
  readonly scored: number;
  readonly scores: readonly (Column & { readonly mean: number | null })[];
}

export interface Compared extends Column {
  readonly episodes: number;
  readonly first: number;
  readonly second: number;
  readonly difference: { readonly mean: number; readonly low: number | null; readonly high: number | null };
  readonly p: number;
}
export interface Comparison {
  readonly runs: readonly [Run, Run];
  /** That both have, and that only one has. */
  readonly episodes: number;
  readonly only_first: number;
  readonly only_second: number;
  readonly outcomes: boolean;
  readonly columns: readonly Compared[];
  readonly differing: number;
  readonly list: readonly {
    readonly episode: string; readonly instruction?: string; readonly first: EpisodeEnd | Broken; readonly second: EpisodeEnd | Broken;
  }[];
}

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
  /** Why the response has no call: "empty", "length", "refusal", "filter". */
  readonly flaw?: string;
  readonly prompt_tokens?: number;
  readonly answer_tokens?: number;
  readonly at?: At;
  /** Captions of the pictures that the model saw, in the order sent: a place, or nothing for a strip. */
  readonly pictures?: readonly string[];
}
export interface Replay extends Omit<Run, 'episodes'> {
  readonly episode: string;
  readonly instruction: string;
  readonly scan: string | null;
  readonly steps: readonly Step[];
  readonly end: Done & { readonly at?: At };
  /** Absent where goals are hidden. */
  readonly outcome?: Outcome & { readonly spl?: number };
  readonly place_problem?: string;
}

/** The key of a run's split; nothing where it is not known. */
export const keyOfRun = ({ task, split }: Pick<Run, 'task' | 'split'>): string | undefined => (task && split ? splitKey({ task, split }) : undefined);

export const address = (parts: Readonly<Record<string, string>>, hash = ''): string => `/replay?${new URLSearchParams(parts)}${hash}`;
export const runPath = (name: string): string => `runs/${encodeURIComponent(name)}`;
export const episodePath = (run: string, episode: string): string => `${runPath(run)}/episodes/${encodeURIComponent(episode)}`;

/** "go_to B"; "no call" where none could be read. */
export const callText = (call: Call | null): string => (call ? `${call.tool} ${call.argument}`.trim() : 'no call');

const flaws = new Map([['empty', 'The response is empty.'], ['length', 'The response was cut off at the limit of tokens.'],
  ['refusal', 'The model refused.'], ['filter', 'A filter took the response away.']]);
/** What stands in place of a response that has no text. */
export const noResponseText = ({ flaw }: Pick<Step, 'flaw'>): string => flaws.get(flaw ?? '') ?? 'No text beside the action.';

const endings: Record<Ending, string> = {
  stopped: 'stopped', 'out-of-steps': 'ran out of steps', mistakes: 'made too many mistakes one after another',
  refused: 'was broken off by the server',
};

/** "stopped after 5 steps, 1 mistake", and the reason where there is one. */
export function endText({ ending, steps, mistakes, reason }: Done): string {
  const faults = mistakes === 0 ? 'no mistake' : counted(mistakes, 'mistake');
  return `${endings[ending] ?? ending} after ${counted(steps, 'step')}, ${faults}${reason ? `; ${reason}` : ''}`;
}

/** "It stopped 1.2 m from the goal: success, SPL 0.87. Success is …" */
export function outcomeWords({ outcome, end }: Pick<Replay, 'outcome' | 'end'>): string {
  if (!outcome) return '';
  const verb = end.ending === 'stopped' ? 'stopped' : 'ended';
  const where = outcome.error === null ? 'where no path leads to the goal' : `${outcome.error.toFixed(1)} m from the goal`;
  const named = outcome.answer ?? undefined;
  const object = named === undefined ? '' : `, and named ${named ? 'the right object' : 'another object'}`;
  const spl = outcome.spl === undefined ? '' : `, SPL ${outcome.spl.toFixed(2)}`;
  return `It ${verb} ${where}${object}: ${outcome.success ? 'success' : 'failure'}${spl}. ${ruleText(outcome)}`;
}

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
