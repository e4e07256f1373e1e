/** Pieces of an instruction beside the path: which of them a moment of the fly-through is about. */
import type { Moment } from '../viewer/flight.ts';
import type { Part } from './episode.ts';

type Places = readonly [number, number];

/**
 * Indices of the pieces that describe what happens at a moment. On the way those of that step. At a viewpoint those without a move there, else
 * those that begin there, go through it, or end there.
 * @param path viewpoints
 */
export function partsAt(parts: readonly Pick<Part, 'places'>[], path: readonly number[], { from, to }: Pick<Moment, 'from' | 'to'>): number[] {
  const where = (fits: (places: Places) => boolean): number[] =>
    parts.flatMap(({ places }, k) => (places && fits(places) ? [k] : []));
  const step = from === to ? -1 : path.findIndex((v, k) => v === from && path[k + 1] === to);
  if (step >= 0) return where(([first, last]) => first <= step && step < last);
  const at = path.indexOf(from);
  const rules: readonly ((places: Places) => boolean)[] = [
    ([first, last]) => first === at && last === at,
    ([first]) => first === at,
    ([first, last]) => first < at && at < last,
    ([, last]) => last === at,
  ];
  for (const rule of rules) {
    const found = where(rule);
    if (found.length > 0) return found;
  }
  return [];
}

/** The words of a piece as people write them: a comma, a full stop and "'s" follow their word. */
export const pieceText = (words: readonly string[]): string => words.join(' ').replace(/ (?=[.,!?;:]|n?'\w)/g, '');

/** "viewpoint 2", "viewpoints 2 to 4": counted from 1. */
export const placesText = ([first, last]: Places): string =>
  (first === last ? `viewpoint ${first + 1}` : `viewpoints ${first + 1} to ${last + 1}`);
