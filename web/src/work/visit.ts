/** A worker's visit: joining by a link, and asking the server as that worker. Shapes: /api/v1/openapi.json. */
import type { Collection, Entry } from '../collections.ts';
import { api, json } from '../page.ts';

export interface Task {
  /** Absent in an example. */
  readonly task?: number;
  readonly kind: 'write' | 'walk';
  readonly scan: string;
  /** Of the start, radians. */
  readonly heading: number;
  /** To be described. */
  readonly path?: readonly string[];
  /** To be followed, from `start`. */
  readonly instruction?: string;
  readonly start?: string;
  readonly draft?: object;
}

export interface Completion {
  readonly kind: 'self' | 'mturk' | 'prolific';
  readonly action?: string;
  readonly fields?: Readonly<Record<string, string>>;
  readonly url?: string;
  readonly code?: string;
}

export interface Visit {
  readonly consented: boolean;
  /** Tasks handed in. */
  readonly done: number;
  readonly of?: number;
  readonly finished: boolean;
  readonly task: Task | null;
  readonly why?: 'finished' | 'none-left' | 'all-leased' | 'closed';
  readonly walked?: { readonly bonus?: boolean };
  readonly completion?: Completion;
}

interface Joined {
  readonly preview: boolean;
  readonly collection: Collection;
  readonly worker?: string;
  readonly token?: string;
  readonly visit?: Visit;
  readonly example?: Task;
}

export type Submission =
  | { readonly instruction: string; readonly seconds: number; readonly flags: readonly string[] }
  | { readonly steps: readonly Entry[]; readonly camera: { width: number; height: number; vfov: number } };

/** What the link says, and who this browser was the last time. */
function parameters(collection: string): Record<string, string> {
  const query = Object.fromEntries(new URLSearchParams(location.search));
  const known = remembered(collection);
  return known ? { worker: known, ...query } : query;
}

const keyOf = (collection: string): string => `enfilade-worker/${collection}`;

function remembered(collection: string): string | null {
  try {
    return localStorage.getItem(keyOf(collection));
  } catch {
    return null; // a browser that keeps nothing for frames of other sites
  }
}

function remember(collection: string, worker: string): void {
  try {
    localStorage.setItem(keyOf(collection), worker);
  } catch {
    // Then a reload is a new worker; the platforms say who it is anyway.
  }
}

/** The server, asked by a worker. */
export class WorkApi {
  private readonly token: string;

  constructor(token: string) {
    this.token = token;
  }

  consent = (): Promise<Visit> => this.call('PUT', 'visit/consent', {});
  /** The next task, or the one that is held. */
  lease = (): Promise<Visit> => this.call('POST', 'visit/task', {});
  giveBack = (task: number): Promise<Visit> => this.call('DELETE', `tasks/${task}`);
  handIn = (task: number, work: Submission): Promise<Visit> => this.call('PUT', `tasks/${task}/submission`, work);
  keepDraft = async (task: number, draft: object): Promise<void> => {
    await this.call('PUT', `tasks/${task}/draft`, { draft });
  };

  // Not by a cookie: platforms show these pages in a frame, where browsers send none.
  private call<T>(method: string, path: string, body?: unknown): Promise<T> {
    const sent = body === undefined ? { method, headers: {} } : json(body, method);
    return api.call(path, { ...sent, headers: { ...sent.headers, Authorization: `Bearer ${this.token}` } });
  }
}

export type Arrival =
  | { readonly preview: true; readonly collection: Collection; readonly example: Task | undefined }
  | { readonly preview: false; readonly collection: Collection; readonly visit: Visit; readonly api: WorkApi };

/** Joins the collection that the page's address names. The same worker comes back to the same task. */
export async function arrive(): Promise<Arrival> {
  const name = new URLSearchParams(location.search).get('collection');
  if (!name) throw new Error('This link names no collection. Ask those who sent it to you for the whole link.');
  const joined = await api.call<Joined>(`collections/${encodeURIComponent(name)}/join`, json({ parameters: parameters(name) }));
  const { collection, worker, token, visit, example } = joined;
  if (joined.preview || !token || !visit) return { preview: true, collection, example };
  if (collection.platform.kind === 'self' && worker) remember(name, worker);
  return { preview: false, collection, visit, api: new WorkApi(token) };
}
