/** What the kinds of tasks are called. */
import type { Collection, Kind } from './collections.ts';

export const kindTexts: Readonly<Record<Kind, string>> = {
  write: 'People write directions', walk: 'People walk by directions', describe: 'People describe objects (as for REVERIE)',
  find: 'People find described objects, to verify them', guide: 'People guide along a path while they walk it (as for RxR)',
  dialogue: 'Two people talk: navigator and oracle (as for CVDN)',
};

/** What an item of a collection is. */
export const itemTexts: Readonly<Record<Kind, string>> = {
  write: 'path', walk: 'instruction', describe: 'object', find: 'description', guide: 'path', dialogue: 'goal',
};

type Platform = Collection['platform']['kind'];

/** How workers come to a collection. */
export const platformTexts: Readonly<Record<Platform, string>> = {
  self: 'a link that you send', mturk: 'Mechanical Turk', prolific: 'Prolific',
};
