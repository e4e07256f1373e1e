import { describe, expect, it } from 'vitest';
import { anyEpisode, type Offer } from './any_episode.ts';
import type { Split } from './splits.ts';

/** Ids of a split's instructions by building. */
type Data = Readonly<Record<string, Readonly<Record<string, readonly string[]>>>>;

/** Reproducible, from 0 to below 1 (mulberry32). */
function random(seed: number): () => number {
  let state = seed;
  return () => {
    state = (state + 0x6d2b79f5) | 0;
    let t = Math.imul(state ^ (state >>> 15), state | 1);
    t = (t + Math.imul(t ^ (t >>> 7), t | 61)) ^ t;
    return ((t ^ (t >>> 14)) >>> 0) / 2 ** 32;
  };
}

const ids = (name: string, count: number): string[] => Array.from({ length: count }, (_, k) => `${name}_${k}`);

/** The server's answers about a data set. */
class Server {
  asked = 0;
  private readonly data: Data;
  readonly offer: Offer;

  constructor(data: Data, scans: readonly string[], hidden: readonly string[] = ['test'], withoutPictures: readonly string[] = []) {
    this.data = data;
    const splits = Object.entries(data).map(([key, buildings]): Split => {
      const [task, split] = key.includes('/') ? key.split('/') as [string, string] : ['r2r', key];
      return { split, task, title: task, instructions: Object.values(buildings).flat().length, goals_hidden: hidden.includes(key) };
    });
    this.offer = { splits, scans: scans.map((scan) => ({ scan, pictures: !withoutPictures.includes(scan) })) };
  }

  readonly ask = (path: string) => {
    ++this.asked;
    const { pathname, searchParams: query } = new URL(path, 'http://server/');
    const split = pathname.split('/')[2]!;
    const task = query.get('task');
    const all = this.data[task ? `${task}/${split}` : split]?.[query.get('scan')!] ?? [];
    const episodes = all.slice(Number(query.get('offset'))).slice(0, Number(query.get('limit'))).map((instruction_id) => ({ instruction_id }));
    return Promise.resolve({ matching: all.length, episodes });
  };
}

/** As `enfilade homes` splits its sets: each home is in train (and val_seen), val_unseen or test. */
const homes = (count: number, unseen: number, tests: number): Server => {
  const names = Array.from({ length: count }, (_, k) => `home${String(k + 1).padStart(4, '0')}`);
  const of = (list: readonly string[], split: string) => Object.fromEntries(list.map((name, k) => [name, ids(`${split}-${name}`, 3 + 3 * (k % 4))]));
  const [inTest, inUnseen, inTrain] = [names.slice(0, tests), names.slice(tests, tests + unseen), names.slice(tests + unseen)];
  return new Server({
    train: of(inTrain, 'train'), val_seen: of(inTrain.slice(0, 1), 'val_seen'), val_unseen: of(inUnseen, 'val_unseen'), test: of(inTest, 'test'),
    'reverie/val_unseen': of(inUnseen, 'reverie'), 'rxr/train': of(inTrain, 'rxr'),
  }, names);
};

describe('any episode', () => {
  it.each([['the two homes of a demo', homes(2, 1, 0)], ['three homes', homes(3, 1, 1)], ['sixteen homes', homes(16, 3, 3)]])(
    'is found at each of 200 visits of %s, and is no hidden one', async (_, server) => {
      const found = new Set<string>();
      for (let visit = 0; visit < 200; ++visit) {
        const episode = await anyEpisode(server.ask, server.offer, {}, random(visit));
        expect(episode, `visit ${visit}`).toBeDefined();
        expect(episode!.id.startsWith(`${episode!.split}-`)).toBe(true);
        found.add(episode!.split);
      }
      expect([...found].sort()).toEqual(['train', 'val_seen', 'val_unseen']);
    });

  it('is found where only one split has the only building with pictures', async () => {
    const data = { train: { a: ids('a', 1) }, val_seen: { a: ids('b', 1) }, val_unseen: { z: ids('z', 2) } };
    const server = new Server(data, ['a', 'b', 'c', 'z'], [], ['a']);
    for (let visit = 0; visit < 50; ++visit) {
      expect((await anyEpisode(server.ask, server.offer, {}, random(visit)))?.split).toBe('val_unseen');
    }
  });

  it('is of the building or split that was asked for', async () => {
    const server = homes(16, 3, 3);
    for (let visit = 0; visit < 50; ++visit) {
      expect((await anyEpisode(server.ask, server.offer, { scan: 'home0005' }, random(visit)))?.id).toMatch(/^val_unseen-home0005_/);
      expect((await anyEpisode(server.ask, server.offer, { split: 'reverie/val_unseen' }, random(visit)))?.id).toMatch(/^reverie-/);
    }
    expect(await anyEpisode(server.ask, server.offer, { scan: 'home0001' }), 'its goals are hidden').toBeUndefined();
    expect(await anyEpisode(server.ask, server.offer, { scan: 'nowhere' })).toBeUndefined();
    expect(await anyEpisode(server.ask, server.offer, { split: 'test' })).toBeUndefined();
  });

  it('is of another benchmark only where R2R has none', async () => {
    const server = new Server({ test: { a: ids('t', 3) }, 'rxr/val_seen': { a: ids('x', 3) }, 'reverie/val_seen': { a: ids('r', 3) } }, ['a']);
    expect((await anyEpisode(server.ask, server.offer, {}, random(1)))?.split).toBe('rxr/val_seen');
  });

  it('asks for nothing where there is nothing', async () => {
    const server = new Server({ test: { a: ids('t', 3) } }, ['a']);
    expect(await anyEpisode(server.ask, server.offer)).toBeUndefined();
    expect(server.asked).toBe(0);
  });

  it('is any of a building\'s', async () => {
    const server = new Server({ train: { a: ids('a', 5) } }, ['a']);
    const found = new Set<string>();
    for (let visit = 0; visit < 100; ++visit) found.add((await anyEpisode(server.ask, server.offer, {}, random(visit)))!.id);
    expect(found.size).toBe(5);
  });
});
