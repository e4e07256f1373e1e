/** Splits of all benchmarks by one name, their key: "val_unseen" of R2R, "reverie/val_unseen" of another. */

export interface Split {
  readonly split: string;
  /** "r2r", "reverie", ... */
  readonly task: string;
  /** The benchmark for people: "REVERIE". */
  readonly title: string;
  readonly instructions: number;
  readonly goals_hidden: boolean;
}

/** A split of a benchmark in continuous space, whose episodes are on /roam. */
export type FloorSplit = Pick<Split, 'split' | 'task' | 'title'>;

/** What a server has: splits?task=all. */
export interface SplitList {
  readonly splits: readonly Split[];
  readonly continuous: readonly FloorSplit[];
}

const usual = 'r2r';
const usualOnFloor = 'r2r-ce';

export const splitKey = ({ split, task }: Pick<Split, 'split' | 'task'>): string =>
  (task === usual ? split : `${task}/${split}`);

export const isOnFloor = (key: string): boolean => parseKey(key).task.endsWith('-ce');

/** /roam?split= has R2R-CE's splits without the benchmark. */
export const floorKey = (split: string): string => (split.includes('/') ? split : splitKey({ task: usualOnFloor, split }));

/** Its inverse. */
export function parseKey(key: string): { readonly task: string; readonly split: string } {
  const at = key.indexOf('/');
  return at < 0 ? { task: usual, split: key } : { task: key.slice(0, at), split: key.slice(at + 1) };
}

/** What is asked of the server for a split's episodes. */
export function episodesOf(key: string, query: Readonly<Record<string, string>>): string {
  const { task, split } = parseKey(key);
  const all = new URLSearchParams({ ...query, ...(task !== usual && task !== usualOnFloor && { task }) });
  return `${isOnFloor(key) ? 'continuous' : 'splits'}/${encodeURIComponent(split)}/episodes?${all}`;
}

/** The page of an episode. @param list more of its address: how the list is filtered in which it was chosen */
export function episodePage(key: string, id: string, list: Readonly<Record<string, string>> = {}): string {
  if (!isOnFloor(key)) return `/view?${new URLSearchParams({ split: key, id, ...list })}`;
  const { task, split } = parseKey(key);
  return `/roam?${new URLSearchParams({ split: task === usualOnFloor ? split : key, id })}`;
}

/** A split in a list of those of one benchmark: "val_unseen (2,349)". */
export interface OfferedSplit {
  readonly key: string;
  readonly split: string;
  readonly text: string;
}
/** A benchmark with the splits that can be chosen. */
export interface Offered {
  readonly task: string;
  /** For people: "REVERIE". */
  readonly title: string;
  readonly splits: readonly OfferedSplit[];
}

/** The usual splits, first those in which one looks most often. Others of the name, as SOON's val_unseen_house, stand beside them. */
const order = ['val_unseen', 'val_seen', 'test', 'train'];

function rank(split: string): number {
  const k = order.findIndex((name) => split.startsWith(name));
  return k < 0 ? order.length : k;
}

/** All benchmarks in the server's order, R2R's first, with their splits; none without an episode. */
export function offeredBenchmarks({ splits, continuous }: SplitList): Offered[] {
  const textOf = ({ split, instructions, goals_hidden }: Split) =>
    `${split} (${instructions.toLocaleString('en-US')}${goals_hidden ? ', goals hidden' : ''})`;
  const all = [...splits.filter(({ instructions }) => instructions > 0).map((one) => ({ ...one, text: textOf(one) })),
    ...continuous.map((one) => ({ ...one, text: one.split }))];
  const tasks = [...new Set(all.map(({ task }) => task))];
  return tasks.map((task) => {
    const own = all.filter((one) => one.task === task);
    return { task, title: own[0]!.title, splits: own.map(({ split, text }) => ({ key: splitKey({ task, split }), split, text }))
      .sort((a, b) => rank(a.split) - rank(b.split)) };
  });
}

/** Whether /play can step through its episodes: no tool of a session gives SOON's answer. */
export const isPlayable = (task: string): boolean => task !== 'soon';

/** Whether success is to end near the end of the reference path. */
export const endCounts = (key: string): boolean => ['r2r', 'r2r-last', 'r4r', 'rxr'].includes(parseKey(key).task);
