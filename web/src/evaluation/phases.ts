/** Phases of an evaluation, and what pages say about them in words. */
import { make } from '../elements/page.ts';
import type { Column } from './ranking.ts';

interface Leakage {
  readonly most_bits: number | null;
  readonly goal_bits: number | null;
  /** Whether the first is more than the second, before both are rounded. */
  readonly gives_all: boolean;
  readonly used_bits?: number | null;
  readonly phases: readonly string[];
}
export interface Phase {
  readonly phase: string;
  readonly title: string;
  readonly split: string;
  /** The benchmark: "reverie", and for people "REVERIE". */
  readonly task: string;
  readonly task_title: string;
  /** Whose formulas: "enfilade" for R2R's own, else the name of a public scorer. */
  readonly scorer: string;
  readonly episodes: number;
  readonly goals_secret: boolean;
  readonly scores: 'public' | 'after-end' | 'ladder' | 'hidden';
  /** The column that ranks. */
  readonly primary: string;
  readonly columns: readonly Column[];
  readonly ends: string | null;
  readonly ended: boolean;
  readonly per_day: number;
  readonly per_team: number | null;
  /** Markdown. */
  readonly rules?: string;
  readonly step?: number;
  readonly teams?: number;
  readonly near_copies?: number;
  readonly leakage?: Leakage;
}
export interface PhaseList {
  readonly registration: 'open' | 'closed';
  readonly phases: readonly Phase[];
}

/** Those of val_unseen first, by which methods are compared; the others stay in the organisers' order. */
export const inOrder = (phases: readonly Phase[]): Phase[] => {
  const later = ({ split }: Phase): number => Number(!split.startsWith('val_unseen'));
  return [...phases].sort((a, b) => later(a) - later(b));
};

export const primaryOf = ({ primary, columns }: Phase): Column => columns.find(({ name }) => name === primary)!;
export const primaryName = (phase: Phase): string => primaryOf(phase).short;

/** What would make a submission, as people type it. @param server its address */
export function commandsOf({ task, split, phase }: Phase, server: string): string {
  const benchmark = task === 'r2r' ? '' : ` --task ${task}`;
  return `enfilade run --data DATA${benchmark} --split ${split} --agent random -o results.json\n`
    + `ENFILADE_TOKEN=TOKEN enfilade submit results.json --server ${server} --phase ${phase} --method "My method"`;
}

/** "REVERIE, scored as duet" */
export const benchmarkOf = ({ task_title, scorer }: Phase): string => (scorer === 'enfilade' ? task_title : `${task_title}, scored as ${scorer}`);

/** Of shares the step is one of shares; of metres it is ten times as many metres. */
const metresOf = (step: number): string => (step * 10).toFixed(2).replace(/\.?0+$/, '');

const number = (value: number): string => value.toLocaleString('en-US');
const dateTime = (iso: string): string => `${iso.slice(0, 16).replace('T', ' ')} UTC`;

/** "10 a day, 20 in all" */
export function limitsOf({ per_day, per_team }: Phase): string {
  return `${number(per_day)} a day${per_team === null ? '' : `, ${number(per_team)} in all`}`;
}

/** When the phase ends or ended; nothing if the organisers have not said. */
export function endOf({ ends, ended }: Phase): string {
  if (ends === null) return ended ? 'The phase has ended.' : '';
  return ended ? `The phase ended on ${dateTime(ends)}.` : `The phase ends on ${dateTime(ends)}.`;
}

/** What is shown of the scores, and when. */
export function showingOf(phase: Phase): string {
  const rounded = `rounded to ${(phase.step ?? 0) * 100} % and ${metresOf(phase.step ?? 0)} m`;
  const step = primaryOf(phase).unit === 'share' ? `${(phase.step ?? 0) * 100} %` : `${metresOf(phase.step ?? 0)} m`;
  if (!phase.goals_secret) return phase.scores === 'hidden' ? 'Only the organisers see its scores.' : '';
  if (phase.scores === 'hidden') return 'Its goals are secret, and only the organisers see its scores.';
  if (phase.ended) return `Its goals are secret: each team has one row, its best by ${primaryName(phase)}, ${rounded}.`;
  if (phase.scores === 'after-end') {
    return `Its goals are secret: scores appear when the phase has ended, one row for each team, ${rounded}. Until then a team learns that its file is valid.`;
  }
  return `Its goals are secret: until the end a team sees its ${primaryName(phase)} only when that is at least ${step} better than its best shown one.`;
}

/** Whether the limits let all of the goals be read. */
export function givesAll({ leakage }: Phase): boolean {
  return leakage?.gives_all ?? false;
}

/** How much of the goals is given away, as the server computes it. */
export function leakageOf(phase: Phase): string {
  const { leakage } = phase;
  if (!leakage) return '';
  const subject = leakage.phases.length > 1 ? `The phases ${leakage.phases.join(', ')} share goals, and together` : 'This phase';
  const whose = leakage.phases.length > 1 ? "this phase's goals" : 'its goals';
  const goals = leakage.goal_bits === null ? whose : `${whose}, which have ${number(leakage.goal_bits)} bits`;
  const most = leakage.most_bits === null
    ? `${subject} can give away all of ${goals}: there is no limit to a team's submissions`
    : `${subject} can give away at most ${number(leakage.most_bits)} bits of ${goals}`;
  const used = leakage.used_bits === undefined || leakage.used_bits === null ? '' : `; ${number(leakage.used_bits)} are used`;
  return `${most}${used}.${givesAll(phase) ? ' So the goals may not stay secret.' : ''}`;
}

/** The same as a line of a page; a warning where all of the goals can be read. Nothing for open goals. */
export function leakageNote(phase: Phase): HTMLElement[] {
  const text = leakageOf(phase);
  return text === '' ? [] : [make('p', { class: givesAll(phase) ? 'notice bad' : 'note' }, text)];
}
