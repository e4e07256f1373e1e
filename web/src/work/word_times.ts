/** When each word of a text was written or said. */
import type { TimedWord } from '../collecting/collections.ts';

/** As the server does: other spaces, such as those that do not break a line, are parts of words. */
const split = (text: string): string[] => text.split(/[ \t\n\v\f\r]+/).filter((word) => word !== '');

/** Of which words begin and end alike. */
function common(a: readonly string[], b: readonly string[]): number {
  let k = 0;
  while (k < a.length && k < b.length && a[k] === b[k]) ++k;
  return k;
}

/**
 * The words of a text that was changed: those that stood there keep their times, new ones have the present. One that was
 * put between others begins no later than the next, so that words begin one after another.
 * @param now seconds
 * @param since when the change began; absent: now
 */
export function retimed(before: readonly TimedWord[], text: string, now: number, since = now): TimedWord[] {
  const words = split(text);
  const old = before.map(({ word }) => word);
  const head = common(old, words);
  const tail = Math.min(common([...old].reverse(), [...words].reverse()), old.length - head, words.length - head);
  const after = before.slice(old.length - tail);
  const latest = after[0]?.start ?? Infinity;
  const fresh = words.slice(head, words.length - tail);
  const lost = before.slice(head, old.length - tail);
  const earliest = Math.min(before[head - 1]?.start ?? 0, latest);
  const middle: TimedWord[] = [];
  fresh.forEach((word, k) => {
    // A word that is being typed is one, from its first letter to its last.
    const spread = since + ((now - since) * k) / fresh.length;
    const start = Math.min(Math.max(lost[k]?.start ?? spread, middle.at(-1)?.start ?? earliest), latest);
    const end = Math.max(since + ((now - since) * (k + 1)) / fresh.length, start);
    middle.push({ word, start, end: Number.isFinite(latest) ? Math.max(Math.min(end, latest), start) : end });
  });
  return [...before.slice(0, head), ...middle, ...after];
}
