import { describe, expect, it } from 'vitest';
import { firstEpisodes } from './building_episodes.ts';
import type { SplitList } from './splits.ts';

const split = (name: string, task: string, hidden = false) =>
  ({ split: name, task, title: task.toUpperCase(), instructions: 5, goals_hidden: hidden });
const list: SplitList = {
  splits: [split('train', 'r2r'), split('val_unseen', 'r2r'), split('test', 'r2r', true), split('val_unseen', 'reverie')], continuous: [],
};

/** A server of which only these splits have episodes of the building. */
function server(having: readonly string[]) {
  const asked: string[] = [];
  const call = async <T>(path: string): Promise<T> => {
    asked.push(path);
    if (path.startsWith('splits?')) return list as T;
    return { title: 'R2R', matching: having.some((one) => path.startsWith(one)) ? 4 : 0, episodes: [] } as T;
  };
  return { asked, call };
}

describe("a building's episodes", () => {
  it('are those of the first split that has any, val_unseen before train', async () => {
    const { call, asked } = server(['splits/train/', 'splits/val_unseen/']);
    expect(await firstEpisodes({ call }, 'home0001')).toMatchObject({ key: 'val_unseen', title: 'R2R val_unseen', matching: 4 });
    expect(asked[1]).toContain('scan=home0001');
    expect(await firstEpisodes(server(['splits/train/']), 'home0001')).toMatchObject({ key: 'train' });
  });

  it('may be of another benchmark, and none whose goal is hidden', async () => {
    const { call, asked } = server(['splits/test/']);
    expect(await firstEpisodes({ call }, 'home0001')).toBeUndefined();
    expect(asked.filter((path) => path.includes('/test/'))).toEqual([]);
    expect(asked.at(-1)).toContain('task=reverie');
  });
});
