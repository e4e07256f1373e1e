import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import { ServerError } from '../server/api.ts';
import { Drafts, type DraftState } from './drafts.ts';
import { openStorage } from './storage.ts';

describe('a draft', () => {
  const kept = new Map<string, string>();
  const storage = {
    getItem: (key: string) => kept.get(key) ?? null,
    setItem: (key: string, value: string) => void kept.set(key, value),
    removeItem: (key: string) => void kept.delete(key),
  };
  interface Text { readonly text: string }
  const sent: string[] = [];
  const told: DraftState[] = [];
  let reachable = true;
  const open = () => {
    const drafts = new Drafts<Text>('7', storage, async ({ text }) => {
      if (!reachable) throw new TypeError('no network');
      sent.push(text);
    });
    drafts.onState((state) => told.push(state));
    return drafts;
  };

  beforeEach(() => {
    vi.useFakeTimers();
    for (const list of [sent, told]) list.length = 0;
    kept.clear();
    reachable = true;
  });
  afterEach(() => {
    vi.useRealTimers();
  });

  it('is here at once and at the server after a pause', async () => {
    const drafts = open();
    expect(drafts.begin(undefined)).toBeUndefined();
    drafts.change({ text: 'Go' });
    drafts.change({ text: 'Go left' });
    const again = open(); // as after a reload
    expect(again.begin(undefined)?.text).toBe('Go left');
    again.dispose();
    await vi.advanceTimersByTimeAsync(1199);
    expect(sent).toEqual([]);
    await vi.advanceTimersByTimeAsync(1);
    expect(sent).toEqual(['Go left']);
    expect(told).toEqual(['saving', 'saving', 'saved']);
    drafts.forget();
    expect(kept.size).toBe(0);
  });
  it('is sent at once when the page is about to go', async () => {
    const drafts = open();
    await drafts.save();
    expect(sent).toEqual([]); // there is nothing
    drafts.change({ text: 'Go' });
    await drafts.save();
    expect(sent).toEqual(['Go']);
    expect(vi.getTimerCount()).toBe(0);
  });
  it('gives way to a newer one of another browser', async () => {
    open().change({ text: 'old' });
    await vi.advanceTimersByTimeAsync(1200);
    expect(open().begin({ text: 'newer, from elsewhere' })?.text).toBe('newer, from elsewhere');
  });
  it('is sent again when the server was away', async () => {
    const drafts = open();
    reachable = false;
    drafts.change({ text: 'Go' });
    await vi.advanceTimersByTimeAsync(1200);
    expect(told.at(-1)).toBe('here');
    reachable = true;
    await vi.advanceTimersByTimeAsync(5000);
    expect(sent).toEqual(['Go']);
    expect(told.at(-1)).toBe('saved');
    expect(vi.getTimerCount()).toBe(0);
  });
  it('is sent as a sign of life, now and then', async () => {
    const drafts = open();
    for (let second = 0; second < 60; ++second) {
      drafts.stir(() => ({ text: `at ${second}` }));
      await vi.advanceTimersByTimeAsync(1000);
    }
    expect(sent).toEqual(['at 20', 'at 42']); // 20 s after the one before, and the pause
    expect(told).toEqual(['saved', 'saved']);
  });
  it('is not sent again to a server that refuses it', async () => {
    const drafts = new Drafts<Text>('7', storage, async () => {
      throw new ServerError(409, 'lease-expired', 'it lapsed');
    });
    drafts.onState((state) => told.push(state));
    drafts.change({ text: 'Go' });
    await vi.advanceTimersByTimeAsync(60_000);
    expect(told).toEqual(['saving', 'lost']);
    expect(open().begin(undefined)?.text).toBe('Go'); // and still here
  });
  it('outlives rubbish in the storage, and a storage that is full', () => {
    kept.set('enfilade-draft/7', '{"draft": 7');
    expect(open().begin({ text: 'at server' })?.text).toBe('at server');
    const full = openStorage(() => ({
      ...storage, setItem: (_: string, value: string) => { if (value !== '') throw new Error('quota'); },
    }) as unknown as Storage);
    expect(full.lasting).toBe(true);
    const drafts = new Drafts<Text>('7', full, async () => {});
    drafts.change({ text: 'Go' });
    drafts.dispose();
  });
});
