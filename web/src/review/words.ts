/** What reviewers read about submitted work. */
import type { Kind, Work } from '../collecting/collections.ts';

export type State = Work['state'];
export const states: readonly (readonly [State | 'all', string])[] = [
  ['submitted', 'To review'], ['accepted', 'Accepted'], ['rejected', 'Rejected'], ['all', 'All'],
];
export const stateTexts: Readonly<Record<State, string>> = { submitted: 'waiting for review', accepted: 'accepted', rejected: 'rejected' };

const flagTexts: Readonly<Record<string, string>> = {
  short: 'very short', pasted: 'partly pasted', 'goal-not-seen': 'never looked around at the goal',
  'time-mismatch': 'the page claims more time than the server saw',
};
/** Hints that a worker passed over. */
export const hintsOf = ({ flags = [] }: Work): string[] => flags.map((flag) => flagTexts[flag] ?? flag);

/** How a walk or a search ended; nothing of other work, and where the goal is secret. */
export function outcomeOf({ kind, bonus }: Work): string | undefined {
  if (bonus === undefined) return undefined;
  if (kind === 'find') return bonus ? 'pointed at the object' : 'pointed at something else';
  return bonus ? 'stopped within 3 m of the goal' : 'stopped 3 m or more from the goal';
}

export const isWritten = (kind: Kind): boolean => kind === 'write' || kind === 'describe';

/** "4 min 12 s" */
export function duration(seconds: number): string {
  const all = Math.round(seconds);
  const [minutes, rest] = [Math.floor(all / 60), all % 60];
  return minutes > 0 ? `${minutes} min ${rest} s` : `${rest} s`;
}
