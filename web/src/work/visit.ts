/** A worker's visit: joining by a link, and asking the server as that worker. Shapes: /api/v1/openapi.json. */
import type { Collection, Entry, Example, Role, TimedWord, Turn } from '../collecting/collections.ts';
import type { Direction } from '../geometry/geometry.ts';
import { api, json } from '../server/api.ts';
import { storage } from './storage.ts';

export interface Task extends Example {
  /** Absent in an example. */
  readonly task?: number;
  /** In a dialogue: which of the two the worker is. */
  readonly role?: Role;
  readonly draft?: object;
}

/** One of a screening, or an attention check. */
export interface Question {
  readonly question: number;
  readonly text: string;
  readonly choices: readonly string[];
}

/** A task that was not accepted, and why. */
export interface Rejected {
  readonly task: number;
  readonly submitted: string;
  readonly reason: string;
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
  /** Tasks submitted, and how many there will be; practice is not counted. */
  readonly done: number;
  readonly of?: number;
  /** Practice tasks to come. */
  readonly practice?: number;
  readonly finished: boolean;
  readonly task: Task | null;
  readonly why?: 'finished' | 'none-left' | 'all-leased' | 'closed' | 'questions' | 'screened-out';
  readonly questions?: readonly Question[];
  readonly rejected?: readonly Rejected[];
  readonly screened_out?: boolean;
  /** Walks that earned it; known at the very end only. */
  readonly bonuses?: number;
  /** Of the practice task that was just submitted. */
  readonly practised?: { readonly example?: string; readonly reached?: boolean; readonly distance?: number };
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

interface Shot { readonly width: number; readonly height: number; readonly vfov: number }
export type Submission =
  | { readonly instruction: string; readonly seconds: number; readonly flags: readonly string[] }
  | { readonly steps: readonly Entry[]; readonly camera: Shot }
  | { readonly steps: readonly Entry[]; readonly camera: Shot; readonly point: Direction }
  | { readonly instruction: string; readonly words: readonly TimedWord[]; readonly steps: readonly Entry[]; readonly spoken: boolean;
    readonly seconds: number; readonly flags: readonly string[] };

/** How a dialogue stands, as one of the two sees it. */
export interface Dialogue {
  readonly role: Role;
  /** Whether the other one is there. */
  readonly partner: boolean;
  /** Whose turn it is. */
  readonly turn: Role;
  readonly turns: readonly Turn[];
  readonly here: Direction & { readonly viewpoint: string };
  /** For the oracle: the next places of the shortest way, from here. */
  readonly ahead?: readonly string[];
  /** For the oracle: the navigator is where the goal is. */
  readonly arrived?: boolean;
  readonly finished: boolean;
}
export type Act =
  | { readonly say: string }
  | { readonly steps: readonly (Direction & { readonly viewpoint: string })[] }
  | { readonly stop: true };

/** What the link says, and who this browser was the last time. */
function parameters(collection: string): Record<string, string> {
  const query = Object.fromEntries(new URLSearchParams(location.search));
  const known = remembered(collection);
  return known ? { worker: known, ...query } : query;
}

const keyOf = (collection: string): string => `enfilade-worker/${collection}`;
const remembered = (collection: string): string | null => storage.getItem(keyOf(collection));

/** Where nothing is kept, a reload is a new worker; the platforms say who it is anyway. */
function remember(collection: string, worker: string): void {
  storage.setItem(keyOf(collection), worker);
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
  submit = (task: number, work: Submission): Promise<Visit> => this.call('PUT', `tasks/${task}/submission`, work);
  visit = (): Promise<Visit> => this.call('GET', 'visit');
  /** @param after leaves out turns up to that one */
  dialogue = (task: number, after: number): Promise<Dialogue> => this.call('GET', `tasks/${task}/dialogue?after=${after}`);
  act = (task: number, act: Act, after: number): Promise<Dialogue> => this.call('POST', `tasks/${task}/dialogue?after=${after}`, act);
  answer = (answers: readonly { question: number; choice: string }[]): Promise<Visit> =>
    this.call('PUT', 'visit/answers', { answers });
  /** Is sent even if the page goes at that moment. */
  keepDraft = async (task: number, draft: object): Promise<void> => {
    await this.call('PUT', `tasks/${task}/draft`, { draft });
  };

  // Not by a cookie: platforms show these pages in a frame, where browsers send none.
  private call<T>(method: string, path: string, body?: unknown): Promise<T> {
    const sent = body === undefined ? { method, headers: {} } : json(body, method);
    // So that the last words arrive when the page goes; browsers do that for up to 64 kB.
    const keepalive = path.endsWith('/draft') && 'body' in sent && sent.body.length < 60_000;
    return api.call(path, { ...sent, keepalive, headers: { ...sent.headers, Authorization: `Bearer ${this.token}` } });
  }
}

type Arrival =
  | { readonly preview: true; readonly collection: Collection; readonly example: Task | undefined }
  | { readonly preview: false; readonly collection: Collection; readonly visit: Visit; readonly api: WorkApi };

/** The page's address names nothing. */
export class BadLink extends Error {}

/** The collection that an address names. Throws BadLink. */
export function collectionOf(query: URLSearchParams): string {
  const name = query.get('collection');
  if (!name) throw new BadLink('This link names no collection. Ask those who sent it to you for the whole link.');
  return name;
}

/** Joins the collection that the page's address names. The same worker comes back to the same task. */
export async function arrive(): Promise<Arrival> {
  const name = collectionOf(new URLSearchParams(location.search));
  const joined = await api.call<Joined>(`collections/${encodeURIComponent(name)}/join`, json({ parameters: parameters(name) }));
  const { collection, worker, token, visit, example } = joined;
  if (joined.preview || !token || !visit) return { preview: true, collection, example };
  if (collection.platform.kind === 'self' && worker) remember(name, worker);
  return { preview: false, collection, visit, api: new WorkApi(token) };
}
