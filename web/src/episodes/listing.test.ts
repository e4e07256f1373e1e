import { describe, expect, it } from 'vitest';
import { Api } from '../server/api.ts';
import type { Episode } from './episode.ts';
import { type Filters, parseFilters, perPage } from './filters.ts';
import { allEpisodes, inOrder, Listing, placeIn } from './listing.ts';

const length = 1201;
const episode = (k: number): Episode => ({
  instruction_id: `${k}_0`, path_id: k, scan: k % 2 === 0 ? 'a' : 'b', heading: 0, instruction: k % 3 === 0 ? 'Turn LEFT.' : 'Go.',
  start: 'v0', path: ['v0'], distance: (7 * k) % length,
});

/** A split of a server, by its own rules. */
class Local extends Api {
  readonly asked: string[] = [];
  override async call<T>(path: string): Promise<T> {
    this.asked.push(path);
    const query = new URLSearchParams(path.split('?')[1]);
    const all = Array.from({ length }, (_, k) => episode(k));
    const [offset, limit] = [Number(query.get('offset')), Number(query.get('limit'))];
    if (path.startsWith('continuous/')) {
      const one = { id: '7', trajectory: '3', scan: 'a', heading: 1, instruction: 'Go.', path: [[0, 0, 0]], distance: 4 };
      return { matching: 1, episodes: [one] } as T;
    }
    return { matching: all.length, episodes: all.slice(offset, offset + limit) } as T;
  }
}
const filters = (search: string): Filters => parseFilters(search, ['val_seen', 'r2r-ce/val_seen']);

describe('a list of episodes', () => {
  it('takes in splits of any size', async () => {
    const all = await allEpisodes(new Local(), 'train');
    expect(all.length).toBe(length);
    expect(new Set(all.map(({ instruction_id }) => instruction_id)).size).toBe(length);
  });

  it('is the server\'s where it can be', async () => {
    const api = new Local();
    const found = await new Listing(api).find(filters('?q=turn&scan=a&offset=50'), undefined);
    expect(api.asked).toEqual(['splits/val_seen/episodes?q=turn&scan=a&offset=50&limit=50']);
    expect(found.episodes.length).toBe(perPage);
  });

  it('is made in the browser, of the split asked for once, where an order decides', async () => {
    const api = new Local();
    const listing = new Listing(api);
    const longest = filters('?sort=longest&q=left&scan=a');
    const { matching, episodes } = await listing.find(longest, undefined);
    const own = Array.from({ length }, (_, k) => episode(k)).filter(({ scan, instruction }) => scan === 'a' && instruction === 'Turn LEFT.');
    expect(matching).toBe(own.length);
    const lengths = episodes.map(({ distance }) => distance!);
    expect(lengths).toEqual(own.map(({ distance }) => distance!).sort((x, y) => y - x).slice(0, perPage));
    const place = (await listing.place(longest, undefined, episodes[1]!.instruction_id))!;
    expect(place).toEqual({ number: 2, of: matching, previous: episodes[0]!.instruction_id, next: episodes[2]!.instruction_id });
    expect(await listing.place(longest, undefined, '1_0'), 'of the other building').toBeUndefined();
    expect(api.asked.length).toBe(3); // pages of 500
  });

  it('forgets also what it was asking for when the results changed', async () => {
    const api = new Local();
    const listing = new Listing(api);
    const before = listing.find(filters('?sort=longest'), undefined);
    listing.forget();
    await before;
    const { length: asked } = api.asked;
    await listing.find(filters('?sort=longest'), new Map());
    expect(api.asked.length).toBe(2 * asked);
  });

  it('has no neighbour beyond its ends', () => {
    const list = [episode(0), episode(1)];
    expect(placeIn(list, '0_0')).toEqual({ number: 1, of: 2, next: '1_0' });
    expect(placeIn(list, '1_0')).toEqual({ number: 2, of: 2, previous: '0_0' });
  });

  it('puts episodes without a number last', () => {
    const errors = new Map([['0_0', 5], ['2_0', Infinity]]);
    const list = [episode(0), episode(1), episode(2)];
    expect(inOrder(list, errors, 'error-down').map(({ instruction_id }) => instruction_id)).toEqual(['2_0', '0_0', '1_0']);
    expect(inOrder(list, errors, 'error-up').map(({ instruction_id }) => instruction_id)).toEqual(['0_0', '2_0', '1_0']);
  });

  it('shows continuous episodes too', async () => {
    const { matching, episodes } = await new Listing(new Local()).find(filters('?split=r2r-ce/val_seen'), undefined);
    expect(matching).toBe(1);
    expect(episodes).toEqual([{ instruction_id: '7', path_id: 3, scan: 'a', heading: 1, instruction: 'Go.', start: '', path: [], distance: 4 }]);
  });
});
