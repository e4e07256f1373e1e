/**
 * What platforms do with a study: pages of another site than the server's. `localhost` and `127.0.0.1` are two sites for
 * a browser, so a frame of the one in the other has third-party storage.
 */
import { createServer, type IncomingMessage, type Server } from 'node:http';
import type { AddressInfo } from 'node:net';
import type { Frame, Page } from 'playwright-core';

const escaped = (text: string): string => text.replaceAll('&', '&amp;').replaceAll('"', '&quot;');

async function bodyOf(request: IncomingMessage): Promise<URLSearchParams> {
  let body = '';
  for await (const chunk of request) body += String(chunk);
  return new URLSearchParams(body);
}

export interface StandIn {
  readonly origin: string;
  /** Forms that Mechanical Turk was sent. */
  readonly forms: readonly URLSearchParams[];
  /** The page in which a worker sees the task. */
  page(address: string): string;
  stop(): Promise<void>;
}

/**
 * Mechanical Turk: an ExternalQuestion in a frame, with the sandbox that its page for workers has, and the address that
 * takes the form. A form without anything but the assignment is refused, as there.
 */
export async function openTurk(): Promise<StandIn> {
  const forms: URLSearchParams[] = [];
  const server: Server = createServer((request, response) => {
    void (async () => {
      const url = new URL(request.url!, 'http://stand-in');
      response.setHeader('Content-Type', 'text/html');
      if (request.method === 'GET') {
        const address = escaped(url.searchParams.get('show') ?? '');
        return response.end(`<!doctype html><title>HIT</title><h1>A HIT</h1>
<iframe title="HIT" width="1000" height="800" sandbox="allow-forms allow-modals allow-popups allow-same-origin allow-scripts" src="${address}"></iframe>`);
      }
      const form = await bodyOf(request);
      const good = url.pathname === '/mturk/externalSubmit' && form.get('assignmentId') && [...form.keys()].length > 1;
      if (good) forms.push(form);
      response.statusCode = good ? 200 : 400;
      response.end(good ? '<p>Taken by the stand-in</p>' : '<p>There was a problem submitting your results</p>');
    })();
  });
  await new Promise<void>((resolve) => server.listen(0, '127.0.0.1', resolve));
  const origin = `http://localhost:${(server.address() as AddressInfo).port}`;
  return {
    origin, forms,
    page: (address) => `${origin}/?${new URLSearchParams({ show: address })}`,
    stop: () => new Promise((resolve) => server.close(() => resolve())),
  };
}

/** What a frame may keep: the names of the errors that it gets, where it may not. */
export const storageOf = (frame: Frame): Promise<Record<'local' | 'session' | 'cookie', string>> =>
  frame.evaluate(() => {
    const tried = (attempt: () => string) => {
      try {
        return attempt();
      } catch (error) {
        return (error as Error).name;
      }
    };
    return {
      local: tried(() => { localStorage.setItem('probe', '1'); return 'kept'; }),
      session: tried(() => { sessionStorage.setItem('probe', '1'); return 'kept'; }),
      cookie: tried(() => { document.cookie = 'probe=1; path=/'; return document.cookie.includes('probe') ? 'kept' : 'nothing'; }),
    };
  });

/** The frame in which the task is. */
export async function frameOf(page: Page): Promise<Frame> {
  const element = await page.waitForSelector('iframe');
  const frame = await element.contentFrame();
  await frame!.waitForLoadState();
  return frame!;
}
