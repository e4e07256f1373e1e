import { describe, expect, it } from 'vitest';
import { retimed } from './word_times.ts';

const times = (words: readonly { word: string; start: number; end: number }[]) => words.map(({ word, start, end }) => [word, start, end]);

describe('times of words', () => {
  it('are those of their typing', () => {
    let words = retimed([], 'G', 1);
    words = retimed(words, 'Go', 2);
    words = retimed(words, 'Go ', 2.5);
    words = retimed(words, 'Go on', 4);
    expect(times(words)).toEqual([['Go', 1, 2], ['on', 4, 4]]);
  });

  it('stay as they are where other words change, and never run back', () => {
    const typed = retimed(retimed([], 'Go', 1), 'Go on', 3);
    const put = retimed(typed, 'Go right on', 9);
    expect(times(put)).toEqual([['Go', 1, 1], ['right', 3, 3], ['on', 3, 3]]);
    expect(times(retimed(put, 'Go on', 12))).toEqual(times(typed));
    expect(retimed(put, '', 13)).toEqual([]);
  });

  it('are spread over what was said at once', () => {
    expect(times(retimed([], 'past the sofa', 6, 3))).toEqual([['past', 3, 4], ['the', 4, 5], ['sofa', 5, 6]]);
  });

  it('are of the words that the server counts', () => {
    expect(times(retimed([], 'Go\tto room\u00a03\n', 1))).toEqual([['Go', 1, 1], ['to', 1, 1], ['room\u00a03', 1, 1]]);
  });

  it('run on whatever is done to the text', () => {
    const texts = ['a', 'a b', 'a b c', 'x a b c', 'x a c', 'x y z a c', 'a c', 'c', 'c c c', 'c d c'];
    let words = retimed([], '', 0);
    texts.forEach((text, k) => {
      words = retimed(words, text, k + 1);
      expect(words.map(({ word }) => word).join(' ')).toBe(text);
      words.forEach(({ start, end }, n) => {
        expect(end).toBeGreaterThanOrEqual(start);
        expect(start).toBeGreaterThanOrEqual(words[n - 1]?.start ?? 0);
      });
    });
  });
});
