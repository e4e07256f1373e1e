import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import { Api, reach, reachability, ServerError, Silence } from './api.ts';

const down = () => Promise.reject(new TypeError('Failed to fetch'));
const answer = (status: number, body: unknown = {}) => Promise.resolve(new Response(JSON.stringify(body), { status }));

describe('a server that does not answer', () => {
  const told: string[] = [];
  const asked: string[] = [];
  let respond: (address: string) => Promise<Response>;
  for (const kind of ['lost', 'back']) reachability.addEventListener(kind, () => told.push(kind));

  beforeEach(() => {
    vi.useFakeTimers();
    told.length = asked.length = 0;
    vi.stubGlobal('fetch', (address: string) => {
      asked.push(address);
      return respond(address);
    });
  });
  afterEach(async () => {
    respond = () => answer(200);
    await vi.advanceTimersByTimeAsync(10_000);
    vi.useRealTimers();
    vi.unstubAllGlobals();
  });

  it('is told of once, and asked until it answers', async () => {
    respond = down;
    const api = new Api('https://here.example/at/');
    await expect(api.call('scans')).rejects.toThrow(Silence);
    await expect(api.distances('a', 'b')).rejects.toThrow('The server does not answer');
    await vi.advanceTimersByTimeAsync(7000);
    expect(told).toEqual(['lost']);
    expect(asked.filter((address) => address === 'https://here.example/at/healthz')).toHaveLength(4); // at once, and each 2 s
    respond = () => answer(503); // it is ill, but it answers
    await vi.advanceTimersByTimeAsync(2000);
    expect(told).toEqual(['lost', 'back']);
    const before = asked.length;
    await vi.advanceTimersByTimeAsync(20_000);
    expect(asked).toHaveLength(before);
  });

  it('is gone, too, where a proxy answers for it', async () => {
    respond = () => answer(502);
    await expect(reach('/api/v1/scans')).rejects.toThrow(Silence);
    await vi.advanceTimersByTimeAsync(100);
    expect(told).toEqual(['lost']);
    expect(asked).toEqual(['/api/v1/scans', '/healthz']);
  });

  it('is not told of for one request that was lost', async () => {
    respond = (address) => (address === '/healthz' ? answer(200) : down());
    await expect(reach('/api/v1/scans')).rejects.toThrow(Silence);
    await vi.advanceTimersByTimeAsync(10_000);
    expect(told).toEqual([]);
    respond = down; // and later it is gone
    await expect(reach('/api/v1/scans')).rejects.toThrow(Silence);
    await vi.advanceTimersByTimeAsync(100);
    expect(told).toEqual(['lost']);
  });

  it('is another thing than a refusal, or than a request that was taken back', async () => {
    respond = () => answer(404, { error: { code: 'not-found', message: 'no such thing' } });
    await expect(new Api().call('nothing')).rejects.toThrow(new ServerError(404, 'not-found', 'no such thing'));
    respond = () => Promise.reject(new DOMException('The user aborted a request', 'AbortError'));
    await expect(reach('/api/v1/scans')).rejects.toThrow('aborted');
    await vi.advanceTimersByTimeAsync(100);
    expect(told).toEqual([]);
  });
});
