/** Requests to the server. Shapes: /api/v1/openapi.json. */
import type { Layer, Legends, Plan, Scan } from '../scan/scan.ts';

interface Problem {
  readonly severity: 'note' | 'warning' | 'error';
  readonly where: string;
  readonly code: string;
  readonly message: string;
}

/** What a server answers that does not do what was asked. */
export class ServerError extends Error {
  readonly status: number;
  readonly code: string;
  readonly problems: readonly Problem[];
  /** For a results file of another split: the phase that takes it. */
  readonly phase: string | undefined;

  constructor(status: number, code: string, message: string, problems: readonly Problem[] = [], phase?: string) {
    super(message);
    this.status = status;
    this.code = code;
    this.problems = problems;
    this.phase = phase;
  }
}

/** Says when the server stops answering ("lost"), and when it answers again ("back"). */
export const reachability = new EventTarget();

const retryMs = 2000;
let lost = false;

/** What a proxy answers in the place of a server that is gone. */
const isByProxy = (status: number): boolean => status === 502 || status === 504;

const answers = (health: string): Promise<boolean> =>
  fetch(health, { cache: 'no-store' }).then(({ status }) => !isByProxy(status), () => false);

/** Asks the server until it answers. One lost request alone is no silence: a page that is being left ends those on their way. */
async function waitForAnswer(health: string): Promise<void> {
  if (lost) return;
  lost = true;
  if (!(await answers(health))) {
    reachability.dispatchEvent(new Event('lost'));
    do await new Promise((resolve) => setTimeout(resolve, retryMs));
    while (!(await answers(health)));
    reachability.dispatchEvent(new Event('back'));
  }
  lost = false;
}

/** No answer came: the server is gone, or the way to it. */
export class Silence extends TypeError {
  constructor() {
    super('The server does not answer');
  }
}

/** For `catch` where nothing else is to be done: the page says that the server does not answer. */
export function passSilence(error: unknown): void {
  if (!(error instanceof Silence)) throw error;
}

/** As fetch(), of an address with "/api/v1/". Throws Silence if no answer comes; `reachability` then tells of it. */
export async function reach(address: string, init?: RequestInit): Promise<Response> {
  const response = await fetch(address, init).catch((error: unknown) => {
    if (error instanceof TypeError) return undefined;
    throw error;
  });
  if (response && !isByProxy(response.status)) return response;
  void waitForAnswer(`${address.slice(0, address.indexOf('/api/v1/'))}/healthz`);
  throw new Silence();
}

/** A server's API. `base` is its address, "" for the one that the page is from. */
export class Api {
  readonly base: string;

  constructor(base = '') {
    this.base = base.replace(/\/$/, '');
  }

  /** Throws ServerError, or Silence if the server can't be reached. */
  async call<T>(path: string, init: RequestInit = {}): Promise<T> {
    const response = await reach(`${this.base}/api/v1/${path}`, {
      ...init,
      // Tells the server that the request is a script's of its own pages: other sites can't.
      headers: { 'X-Enfilade': '1', ...init.headers },
    });
    const answer: unknown = await response.json().catch(() => undefined);
    if (response.ok) return answer as T;
    const error = (answer as { error?: { code: string; message: string; diagnostics?: Problem[]; phase?: string } })
      ?.error;
    throw new ServerError(
      response.status,
      error?.code ?? 'no-answer',
      error?.message ?? `the server answered with status ${response.status}`,
      error?.diagnostics,
      error?.phase,
    );
  }

  scan(scan: string): Promise<Scan> {
    return this.call(`scans/${encodeURIComponent(scan)}`);
  }

  plan(scan: string): Promise<Plan> {
    return this.call(`scans/${encodeURIComponent(scan)}/plan`);
  }

  legends(scan: string, viewpoint: string): Promise<Legends> {
    return this.call(`${this.viewpoint(scan, viewpoint)}/legends`);
  }

  /** How far it is from a viewpoint, as Surround.parse() reads it. */
  async distances(scan: string, viewpoint: string): Promise<ArrayBuffer> {
    const response = await reach(`${this.base}/api/v1/${this.viewpoint(scan, viewpoint)}/distances`);
    if (!response.ok) throw new Error(`no distances of viewpoint ${viewpoint}`);
    return response.arrayBuffer();
  }

  /** The address of a small picture of a viewpoint, 320 by 200 pixels. */
  thumbnail(scan: string, viewpoint: string): string {
    return `${this.base}/api/v1/${this.viewpoint(scan, viewpoint)}/picture.jpg`;
  }

  private viewpoint(scan: string, viewpoint: string): string {
    return `scans/${encodeURIComponent(scan)}/viewpoints/${encodeURIComponent(viewpoint)}`;
  }

  /** The address of a face's picture, 0 up, 1 back, 2 left, 3 front, 4 right, 5 down. */
  face(scan: string, viewpoint: string, layer: Layer, face: number): string {
    const [folder, suffix] = {
      colour: ['faces', 'jpg'],
      depth: ['depth', 'png'],
      class: ['classes', 'png'],
    }[layer] as [string, string];
    return `${this.base}/api/v1/${this.viewpoint(scan, viewpoint)}/${folder}/${face}.${suffix}`;
  }
}

/** The server that this page is from. */
export const api = new Api();

/** How to send a body. */
export const json = (body: unknown, method = 'POST') => ({
  method, body: JSON.stringify(body), headers: { 'Content-Type': 'application/json' },
});
