import { describe, expect, it } from 'vitest';
import { Api } from '../server/api.ts';
import { findEpisode, listPage, neighbourPage } from './find_episode.ts';

const episode = { instruction_id: '12_0', path_id: 12, scan: 'a', heading: 0, instruction: 'Go.', start: 'v0' };

class Local extends Api {
  asked = '';
  override async call<T>(path: string): Promise<T> {
    this.asked = path;
    return { split: 'val_unseen', title: 'REVERIE', episodes: [episode] } as T;
  }
}

describe('the episode of an address', () => {
  it('comes with its split and with the list in which it was chosen', async () => {
    const api = new Local();
    const found = await findEpisode(api, '?split=reverie/val_unseen&id=12_0&q=red+door&sort=longest&submission=3');
    expect(api.asked).toBe('splits/val_unseen/episodes?id=12_0&scan=&q=red+door&task=reverie');
    expect(found).toMatchObject({
      episode, key: 'reverie/val_unseen', title: 'REVERIE val_unseen', submission: '3', filters: { words: 'red door', order: 'longest' } });
    const { key, filters, submission } = found as Exclude<typeof found, HTMLElement | undefined>;
    expect(neighbourPage({ key, filters, submission: submission! }, '13_0'))
      .toBe('/view?split=reverie%2Fval_unseen&id=13_0&q=red+door&sort=longest&submission=3');
    expect(listPage({ filters })).toBe('/episodes?split=reverie%2Fval_unseen&q=red+door&sort=longest');
    expect(listPage({ filters }, 50), 'the last of the first page').toBe(listPage({ filters }));
    expect(listPage({ filters }, 51)).toBe('/episodes?split=reverie%2Fval_unseen&q=red+door&sort=longest&offset=50');
  });

  it('is none where the address names none', async () => {
    expect(await findEpisode(new Local(), '?split=val_seen')).toBeUndefined();
    expect(await findEpisode(new Local(), '')).toBeUndefined();
  });
});
