import { afterEach, describe, expect, it, vi } from 'vitest';
import { Api, ServerError } from '../server/api.ts';
import { PlayedSession } from './plays.ts';

const state = { session: 7, task: 'reverie', split: 'val_unseen', episode: '12_0', calls: 0, mistakes: 0, ending: null, observation: {} };

/** A server that answers by a function, and what it was asked. */
function server(answer: (path: string, body: unknown) => unknown): { api: Api; asked: [string, unknown][] } {
  const asked: [string, unknown][] = [];
  const api = new Api('');
  api.call = <T>(path: string, init: RequestInit = {}) => {
    const body: unknown = typeof init.body === 'string' ? JSON.parse(init.body) : undefined;
    asked.push([path, body]);
    return Promise.resolve().then(() => answer(path, body) as T);
  };
  return { api, asked };
}

function keepInTab(): Map<string, string> {
  const kept = new Map<string, string>();
  vi.stubGlobal('sessionStorage', {
    getItem: (name: string) => kept.get(name) ?? null, setItem: (name: string, value: string) => kept.set(name, value),
    removeItem: (name: string) => kept.delete(name),
  });
  return kept;
}

describe('a session', () => {
  afterEach(() => vi.unstubAllGlobals());

  it('without an episode is of the one that the server chooses, and is found again by it', async () => {
    const kept = keepInTab();
    const { api, asked } = server((path) => (path === 'sessions' ? { ...state, key: 'play_1' } : state));
    const session = await PlayedSession.open(api, { task: 'reverie', split: 'val_unseen' });
    expect(asked).toEqual([['sessions', { task: 'reverie', split: 'val_unseen' }]]);
    expect(session.state.episode).toBe('12_0');
    expect([...kept.keys()]).toEqual(['enfilade-play:reverie/val_unseen/12_0']);
    await PlayedSession.open(api, { task: 'reverie', split: 'val_unseen', episode: '12_0' });
    expect(asked.slice(1)).toEqual([['sessions/7', undefined]]);
  });

  it('has no outcome where the goal is hidden', async () => {
    keepInTab();
    const { api } = server((path) => {
      if (path === 'sessions') return { ...state, key: 'play_1' };
      throw new ServerError(404, 'not-found', 'split test of r2r has hidden goals: no outcome');
    });
    expect(await (await PlayedSession.open(api, { task: 'reverie', split: 'val_unseen' })).outcome()).toBeUndefined();
  });

  it('tells any other trouble with the outcome', async () => {
    keepInTab();
    const { api } = server((path) => {
      if (path === 'sessions') return { ...state, key: 'play_1' };
      throw new ServerError(409, 'conflict', 'the session goes on: it has no outcome yet');
    });
    const session = await PlayedSession.open(api, { task: 'reverie', split: 'val_unseen' });
    await expect(session.outcome()).rejects.toThrow('goes on');
  });
});
