import { describe, expect, it } from 'vitest';
import { endCounts, episodePage, episodesOf, floorKey, isOnFloor, offeredBenchmarks, parseKey, splitKey } from './splits.ts';

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

  it('of continuous space are asked for elsewhere, and have another page', () => {
    expect(isOnFloor('val_seen')).toBe(false);
    expect(isOnFloor('r2r-ce/val_seen')).toBe(true);
    expect(episodesOf('r2r-ce/val_seen', { q: 'door' })).toBe('continuous/val_seen/episodes?q=door');
    expect(episodesOf('rxr-ce/val_seen', {})).toBe('continuous/val_seen/episodes?task=rxr-ce');
    expect(episodePage('val_seen', '1_0', { q: 'door' })).toBe('/view?split=val_seen&id=1_0&q=door');
    expect(episodePage('r2r-ce/val_seen', '7')).toBe('/roam?split=val_seen&id=7');
    expect(episodePage('rxr-ce/val_seen', '7')).toBe('/roam?split=rxr-ce%2Fval_seen&id=7');
    expect(['val_seen', 'rxr-ce/val_seen'].map(floorKey)).toEqual(['r2r-ce/val_seen', 'rxr-ce/val_seen']);
  });

  it('are offered by benchmark, those in which one looks most often first, and none without an episode', () => {
    const of = (task: string, title: string, split: string, instructions = 14025, goals_hidden = false) =>
      ({ task, title, split, instructions, goals_hidden });
    const r2r = ['train', 'val_seen', 'val_unseen'].map((split) => of('r2r', 'R2R', split));
    const offered = offeredBenchmarks({
      splits: [...r2r, of('r2r', 'R2R', 'test', 4173, true), of('r2r', 'R2R', 'mine'),
        of('r4r', 'R4R', 'val_seen', 0), of('soon', 'SOON', 'train'), of('soon', 'SOON', 'val_unseen_house')],
      continuous: [{ task: 'r2r-ce', title: 'R2R-CE', split: 'val_seen' }],
    });
    expect(offered.map(({ title }) => title)).toEqual(['R2R', 'SOON', 'R2R-CE']);
    expect(offered[0]!.splits.map(({ text }) => text)).toEqual(
      ['val_unseen (14,025)', 'val_seen (14,025)', 'test (4,173, goals hidden)', 'train (14,025)', 'mine (14,025)']);
    expect(offered[1]!.splits.map(({ key }) => key)).toEqual(['soon/val_unseen_house', 'soon/train']);
    expect(offered[2]!.splits).toEqual([{ key: 'r2r-ce/val_seen', split: 'val_seen', text: 'val_seen' }]);
    expect(offeredBenchmarks({ splits: [], continuous: [] })).toEqual([]);
  });

  it('say whether the end of the path is the goal', () => {
    expect(['val_seen', 'rxr/val_seen', 'reverie/val_seen', 'cvdn/val_seen'].map(endCounts)).toEqual([true, true, false, false]);
  });
});
