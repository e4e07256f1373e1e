import { describe, expect, it } from 'vitest';
import { endCounts, episodesOf, parseKey, splitKey, splitTitle } from './splits.ts';

describe('splits', () => {
  it('have one name in all benchmarks', () => {
    for (const one of [{ task: 'r2r', split: 'val_seen' }, { task: 'reverie', split: 'val_seen' }]) {
      expect(parseKey(splitKey(one))).toEqual(one);
    }
    expect(splitKey({ task: 'r2r', split: 'test' })).toBe('test');
  });

  it('are asked of the server', () => {
    expect(episodesOf('val_seen', { id: '1_0' })).toBe('splits/val_seen/episodes?id=1_0');
    expect(episodesOf('cvdn/val_seen', { id: '1' })).toBe('splits/val_seen/episodes?id=1&task=cvdn');
  });

  it('are called by their benchmark where that is not R2R', () => {
    const split = { task: 'r2r', title: 'R2R', split: 'train', instructions: 14025, goals_hidden: false };
    expect(splitTitle(split)).toBe('train (14,025)');
    expect(splitTitle({ ...split, task: 'soon', title: 'SOON', goals_hidden: true })).toBe('SOON train (14,025, goals hidden)');
  });

  it('say whether the end of the path is the goal', () => {
    expect(['val_seen', 'rxr/val_seen', 'reverie/val_seen', 'cvdn/val_seen'].map(endCounts)).toEqual([true, true, false, false]);
  });
});
