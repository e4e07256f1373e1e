import { describe, expect, it } from 'vitest';
import type { Work } from '../collecting/collections.ts';
import { duration, hintsOf, outcomeOf } from './words.ts';

const work = (more: Partial<Work>): Work => ({ kind: 'walk', ...more }) as Work;

describe('what reviewers read', () => {
  it('durations', () => {
    expect([0, 59.4, 59.6, 252].map(duration)).toEqual(['0 s', '59 s', '1 min 0 s', '4 min 12 s']);
  });
  it('outcomes, if they may know them', () => {
    expect(outcomeOf(work({}))).toBeUndefined();
    expect(outcomeOf(work({ bonus: true }))).toBe('stopped within 3 m of the goal');
    expect(outcomeOf(work({ kind: 'find', bonus: false }))).toBe('pointed at something else');
  });
  it('hints', () => {
    expect(hintsOf(work({}))).toEqual([]);
    expect(hintsOf(work({ flags: ['short', 'new-one'] }))).toEqual(['very short', 'new-one']);
  });
});
