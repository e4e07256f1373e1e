/** A session of the arena, stepped through by a person: asking the server, and keeping the key for a reload. */
import type { Outcome } from '../episodes/outcome.ts';
import { type Api, reach, ServerError } from '../server/api.ts';
import type { Ending, Observation } from './runs.ts';

interface PlayState {
  readonly session: number;
  readonly task: string;
  readonly split: string;
  readonly episode: string;
  /** So far, mistakes too. */
  readonly calls: number;
  readonly mistakes: number;
  /** null: it goes on. */
  readonly ending: Ending | null;
  readonly observation: Observation;
}
export interface Wanted {
  readonly task: string;
  readonly split: string;
  readonly episode: string;
}
/** A session's, with the scan that it is in. */
export type SessionOutcome = Outcome & { readonly scan: string };
interface Ticket {
  readonly session: number;
  readonly key: string;
}

const post = (body: unknown): RequestInit => ({ method: 'POST', body: JSON.stringify(body), headers: { 'Content-Type': 'application/json' } });

/** Where a tab keeps the key of an episode's session: no address and no other tab has it. */
const storageName = ({ task, split, episode }: Wanted): string => `enfilade-play:${task}/${split}/${episode}`;

function keptTicket(wanted: Wanted): Ticket | undefined {
  try {
    const kept = JSON.parse(sessionStorage.getItem(storageName(wanted)) ?? 'null') as Partial<Ticket> | null;
    return typeof kept?.session === 'number' && typeof kept.key === 'string' ? { session: kept.session, key: kept.key } : undefined;
  } catch {
    return undefined; // nothing may be kept here, or it is no ticket
  }
}

function keep(wanted: Wanted, ticket: Ticket | undefined): void {
  try {
    if (ticket) sessionStorage.setItem(storageName(wanted), JSON.stringify(ticket));
    else sessionStorage.removeItem(storageName(wanted));
  } catch {
    // then a reload begins anew
  }
}

export class PlayedSession {
  private readonly api: Api;
  private readonly ticket: Ticket;
  state: PlayState;

  private constructor(api: Api, ticket: Ticket, state: PlayState) {
    this.api = api;
    this.ticket = ticket;
    this.state = state;
  }

  /** The one that this tab has begun, or a new one: without an episode the server chooses one. Throws ServerError. */
  static async open(api: Api, wanted: Omit<Wanted, 'episode'> & Partial<Wanted>): Promise<PlayedSession> {
    const kept = wanted.episode === undefined ? undefined : keptTicket({ ...wanted, episode: wanted.episode });
    if (kept) {
      try {
        const session = new PlayedSession(api, kept, {} as PlayState);
        await session.reload();
        return session;
      } catch (error) {
        if (!(error instanceof ServerError) || error.status !== 404) throw error; // 404: the server has forgotten it
      }
    }
    const { key, ...state } = await api.call<PlayState & { key: string }>('sessions', post(wanted));
    keep(state, { session: state.session, key });
    return new PlayedSession(api, { session: state.session, key }, state);
  }

  /** The next open() begins anew. */
  static forget(wanted: Wanted): void {
    keep(wanted, undefined);
  }

  async reload(): Promise<void> {
    this.state = await this.ask<PlayState>('');
  }

  /** Throws ServerError; where another tab or an answer that was lost has gone on, the state is what it is now. */
  async call(tool: string, argument: string): Promise<void> {
    try {
      const { method, body, headers } = post({ tool, argument, after: this.state.calls });
      this.state = await this.ask<PlayState>('/calls', { method: method!, body: body!, headers: headers! });
    } catch (error) {
      if (error instanceof ServerError && error.status === 409) await this.reload();
      throw error;
    }
  }

  /** What is seen all around, with the places' names in it; nothing where there are no pictures. */
  async strip(size: number): Promise<Blob | undefined> {
    const response = await reach(`${this.api.base}/api/v1/sessions/${this.ticket.session}/pictures/strip/0?size=${size}`, { headers: this.header() });
    return response.ok ? response.blob() : undefined;
  }

  /** What was walked, as results files have it. */
  async result(): Promise<string> {
    return JSON.stringify(await this.ask<unknown>('/result'), null, 1);
  }

  /** Nothing where the goal is hidden, and in continuous environments. */
  async outcome(): Promise<SessionOutcome | undefined> {
    try {
      return await this.ask<SessionOutcome>('/outcome');
    } catch (error) {
      if (error instanceof ServerError && error.status === 404) return undefined;
      throw error;
    }
  }

  private header(): Record<string, string> {
    return { 'Enfilade-Session': this.ticket.key };
  }

  private ask<T>(path: string, init: RequestInit = {}): Promise<T> {
    return this.api.call<T>(`sessions/${this.ticket.session}${path}`, { ...init, headers: { ...init.headers, ...this.header() } });
  }
}

/** The call that a key stands for, of those that are possible; nothing for other keys. */
export function callOfKey(key: string, { tools }: Observation): readonly [string, string] | undefined {
  const allows = (tool: string, value: string) => tools.some((one) => one.tool === tool && one.allowed?.includes(value));
  const looks: Record<string, string> = { ArrowLeft: 'left', ArrowRight: 'right', ArrowUp: 'up', ArrowDown: 'down' };
  const moves: Record<string, string> = { ArrowLeft: 'left', ArrowRight: 'right', ArrowUp: 'forward' };
  const place = /^[a-z]$/i.test(key) ? key.toUpperCase() : '';
  for (const [tool, value] of [['go_to', place], ['back_to', place], ['look', looks[key]], ['move', moves[key]]] as const) {
    if (value && allows(tool, value)) return [tool, value];
  }
  return undefined;
}
