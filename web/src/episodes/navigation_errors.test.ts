import { describe, expect, it } from 'vitest';
import type { Scan } from '../scan/scan.ts';
import { Api } from '../server/api.ts';
import type { Episode } from './episode.ts';
import { ErrorMeter, errorsOf } from './navigation_errors.ts';

/** Three viewpoints in a row, 2 m apart, and one that no edge leads to. */
const scan: Scan = {
  scan: 'row', synthetic: true, storeys: [],
  viewpoints: [[0, [1]], [2, [0, 2]], [4, [1]], [6, []]].map(([x, neighbours], k) => ({
    id: `v${k}`, included: true, position: [x as number, 0, 1.5], height: 1.5, neighbours: neighbours as number[], layers: [] })),
};
const episode = (id: string, path?: readonly string[]): Episode =>
  ({ instruction_id: id, path_id: 1, scan: 'row', heading: 0, instruction: 'Go.', start: 'v0', ...(path && { path }) });

class Local extends Api {
  asked = 0;
  override async call<T>(path: string): Promise<T> {
    ++this.asked;
    if (path !== 'scans/row') throw new Error(`nobody asked for ${path}`);
    return scan as T;
  }
}

describe('navigation errors in the browser', () => {
  it('are measured along edges', () => {
    const meter = new ErrorMeter(scan);
    expect(meter.error('v2', 'v0')).toBe(4);
    expect(meter.error('v2', 'v2')).toBe(0);
    expect(meter.error('v2', 'v3')).toBe(Infinity);
    expect(meter.error('v2', 'elsewhere')).toBeUndefined();
  });

  it('are those of the walks whose goal is known', async () => {
    const api = new Local();
    const episodes = [episode('1_0', ['v0', 'v1', 'v2']), episode('1_1', ['v0', 'v1']), episode('2_0'), episode('3_0', ['v2', 'v1'])];
    const results = new Map([['1_0', { viewpoints: ['v0'] }], ['1_1', { viewpoints: ['v0', 'v1'] }], ['2_0', { viewpoints: ['v0'] }]]);
    expect(await errorsOf(api, episodes, results)).toEqual(new Map([['1_0', 4], ['1_1', 0]]));
    expect(api.asked).toBe(1); // for one building
  });
});
