import { describe, expect, it } from 'vitest';
import type { Work } from '../collecting/collections.ts';
import { textOf } from './texts.ts';

describe('a row of work', () => {
  it.each([
    [{ instruction: 'Go on.' }, 'Go on.'],
    [{ instruction: 'Fetch it.', object: { name: 'coat', outlines: {} } }, 'coat: Fetch it.'],
    [{ object: { name: 'bed', outlines: {} } }, 'bed'],
    [{}, 'No text'],
  ])('has its text', (work, words) => {
    expect(textOf(work as Work)).toBe(words);
  });
});
