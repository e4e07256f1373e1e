/** Splits of all benchmarks by one name: "val_unseen" of R2R, "reverie/val_unseen" of another. */

export interface Split {
  readonly split: string;
  /** "r2r", "reverie", ... */
  readonly task: string;
  /** The benchmark for people: "REVERIE". */
  readonly title: string;
  readonly instructions: number;
  readonly goals_hidden: boolean;
}

const usual = 'r2r';

export const splitKey = ({ split, task }: Pick<Split, 'split' | 'task'>): string =>
  (task === usual ? split : `${task}/${split}`);

/** Its inverse. */
export function parseKey(key: string): { readonly task: string; readonly split: string } {
  const at = key.indexOf('/');
  return at < 0 ? { task: usual, split: key } : { task: key.slice(0, at), split: key.slice(at + 1) };
}

/** What is asked of the server for a split's episodes. */
export function episodesOf(key: string, query: Readonly<Record<string, string>>): string {
  const { task, split } = parseKey(key);
  const all = new URLSearchParams({ ...query, ...(task !== usual && { task }) });
  return `splits/${encodeURIComponent(split)}/episodes?${all}`;
}

/** For lists: "val_unseen (2,349)", "REVERIE val_unseen (3,521, goals hidden)". */
export function splitTitle({ split, task, title, instructions, goals_hidden }: Split): string {
  const name = task === usual ? split : `${title} ${split}`;
  return `${name} (${instructions.toLocaleString('en-US')}${goals_hidden ? ', goals hidden' : ''})`;
}

/** Whether success is to end near the end of the reference path. */
export const endCounts = (key: string): boolean => ['r2r', 'r2r-last', 'r4r', 'rxr'].includes(parseKey(key).task);
