/** What was done so far: in this browser at once, at the server soon after. */
import { ServerError } from '../server/api.ts';
import type { Store } from './storage.ts';

/** A draft, and whether the server has it. */
interface Kept<T> {
  readonly draft: T;
  readonly sent: boolean;
}

/** here: the server is out of reach, and is tried again. lost: it will have no more of it. */
export type DraftState = 'saved' | 'saving' | 'here' | 'lost';

const pauseMs = 1200;
const retryMs = 5000;
/** Milliseconds between signs of life to the server while the worker is active: the task stays theirs. */
const signOfLifeMs = 20_000;

/** Keeps the draft of one task. `dispose()` when the task is over. */
export class Drafts<T extends object> {
  private readonly key: string;
  private readonly storage: Omit<Store, 'lasting'>;
  private readonly send: (draft: T) => Promise<void>;
  private tell: (state: DraftState) => void = () => {};
  private timer: ReturnType<typeof setTimeout> | undefined;
  private latest: T | undefined;
  private sentAt = Date.now();
  private over = false;

  /**
   * @param task names the task in the storage
   * @param send rejects if the server can't be reached: it is tried again
   */
  constructor(task: string, storage: Drafts<T>['storage'], send: (draft: T) => Promise<void>) {
    this.key = `enfilade-draft/${task}`;
    this.storage = storage;
    this.send = send;
  }

  onState(tell: (state: DraftState) => void): void {
    this.tell = tell;
  }

  /** The draft to go on with: what the server never got is newer than what it has. */
  begin(atServer: T | undefined): T | undefined {
    const here = this.kept();
    if (!here || here.sent) return atServer;
    this.latest = here.draft;
    this.later(0);
    return here.draft;
  }

  change(draft: T): void {
    this.tell('saving');
    this.take(draft);
  }

  /** The worker is active. */
  stir(draft: () => T): void {
    if (this.timer === undefined && Date.now() - this.sentAt >= signOfLifeMs) this.take(draft());
  }

  /** Sends what is not sent yet, without the pause: the page is about to go. */
  async save(): Promise<void> {
    if (this.over || this.timer === undefined || !this.latest) return;
    clearTimeout(this.timer);
    await this.sendLatest();
  }

  /** The task is submitted or given back: nothing is left of it here. */
  forget(): void {
    this.dispose();
    this.storage.removeItem(this.key);
  }

  dispose(): void {
    this.over = true;
    clearTimeout(this.timer);
  }

  private take(draft: T): void {
    this.latest = draft;
    this.keep(draft, false);
    this.later(pauseMs);
  }

  private later(ms: number): void {
    clearTimeout(this.timer);
    if (this.over) return;
    this.timer = setTimeout(() => void this.sendLatest(), ms);
  }

  private async sendLatest(): Promise<void> {
    const draft = this.latest!;
    const current = () => this.latest === draft && !this.over;
    this.timer = undefined;
    this.sentAt = Date.now();
    try {
      await this.send(draft);
      if (!current()) return;
      this.keep(draft, true);
      this.tell('saved');
    } catch (error) {
      if (!current()) return;
      const refused = error instanceof ServerError && error.status < 500;
      this.tell(refused ? 'lost' : 'here');
      if (refused) this.over = true;
      else this.later(retryMs);
    }
  }

  private keep(draft: T, sent: boolean): void {
    this.storage.setItem(this.key, JSON.stringify({ draft, sent } satisfies Kept<T>));
  }

  private kept(): Kept<T> | undefined {
    try {
      const kept: unknown = JSON.parse(this.storage.getItem(this.key) ?? 'null');
      const { draft, sent } = (kept ?? {}) as Partial<Kept<T>>;
      return draft && typeof draft === 'object' ? { draft, sent: sent === true } : undefined;
    } catch {
      return undefined; // not ours
    }
  }
}
