/** Forms, and logging in with a token. */
import { api, json } from '../server/api.ts';
import { addSiteHeader, byId, make, problems } from './page.ts';

/** Who asks, as the server sees it. */
export interface Who {
  readonly role: 'stranger' | 'team' | 'organiser' | 'reviewer' | 'worker';
  readonly name?: string;
  /** Of a team: whether it may submit where goals are secret. */
  readonly approved?: boolean;
}

/**
 * Runs what a button started, once at a time; what goes wrong is shown in `said`. The button isn't
 * disabled meanwhile, as that would take the focus from those who pressed it by a key.
 */
function start(button: HTMLButtonElement, said: HTMLElement, act: () => Promise<void>): void {
  if (button.ariaDisabled === 'true') return;
  button.ariaDisabled = 'true';
  said.replaceChildren();
  act().catch((error: unknown) => said.replaceChildren(problems(error)))
    .finally(() => { button.ariaDisabled = null; });
}

/** A form, and its button. */
export function form(text: string, fields: readonly HTMLElement[], send: () => Promise<void>): HTMLFormElement {
  const button = make('button', { class: 'main' }, text);
  const said = make('div');
  const element = make('form', {}, ...fields, make('p', {}, button), said);
  element.addEventListener('submit', (event) => {
    event.preventDefault();
    start(button, said, send);
  });
  return element;
}

/** A button that does something; what goes wrong is shown in `said`. */
export function action(text: string, said: HTMLElement, act: () => Promise<void>, attributes: Record<string, string> = {}): HTMLButtonElement {
  const button = make('button', { type: 'button', ...attributes }, text);
  button.addEventListener('click', () => start(button, said, act));
  return button;
}

/**
 * A button that has to be pressed twice, for what can't be undone: the first time it asks. Not
 * confirm(), which browsers leave out in frames of other sites.
 */
export function twice(text: string, question: string, said: HTMLElement, act: () => Promise<void>): HTMLButtonElement {
  const button = make('button', { type: 'button' }, text);
  button.addEventListener('click', () => {
    if (button.textContent === question) start(button, said, act);
    else button.textContent = question;
  });
  button.addEventListener('blur', () => { button.textContent = text; });
  return button;
}

/** A labelled control, and a note below the label that is read with it. */
export function labelled<T extends HTMLElement>(id: string, text: string, control: T, note = ''): [HTMLElement, T] {
  control.id = id;
  const box = make('div', { class: 'field' }, make('label', { for: id }, text));
  if (note) {
    box.append(make('p', { class: 'note', id: `${id}-note` }, note));
    control.setAttribute('aria-describedby', `${id}-note`);
  }
  box.append(control);
  return [box, control];
}

export const field = (id: string, text: string, attributes: Record<string, string> = {}, note = ''): [HTMLElement, HTMLInputElement] =>
  labelled(id, text, make('input', { type: 'text', required: '', ...attributes }), note);

/**
 * The token of a link like "organise#token=…", which no server and no log gets to see. It is taken out of the address,
 * and does not log in before the button is pressed: anyone could send such a link.
 */
function takeLinkedToken(): string {
  const linked = new URLSearchParams(location.hash.slice(1)).get('token');
  if (linked === null) return '';
  history.replaceState(history.state, '', location.pathname + location.search);
  return linked;
}

/** Logging in by a token, which the page's link may have; the page is then loaded anew. */
export function loginForm(label: string): HTMLFormElement {
  const [box, token] = field('token', label, { type: 'password', autocomplete: 'off' });
  token.value = takeLinkedToken();
  return form('Log in', [box], async () => {
    await api.call('session', json({ token: token.value.trim() }));
    location.reload();
  });
}

/** Who is logged in, and the button that ends it. */
export function loggedIn(who: Who): HTMLElement {
  const logOut = make('button', { type: 'button' }, 'Log out');
  logOut.addEventListener('click', () => void api.call('session', { method: 'DELETE' }).then(() => location.reload()));
  return make('p', {}, 'You are ', make('strong', {}, who.name ?? ''), '. ', logOut);
}

/** A page for some roles only: to others it shows how to log in. Nothing if it did. */
export async function onlyFor(roles: readonly Who['role'][], title: string): Promise<Who | undefined> {
  await addSiteHeader();
  const who = await api.call<Who>('session');
  if (roles.includes(who.role)) return who;
  const main = byId('main');
  main.classList.remove('wide');
  main.append(make('h1', {}, title),
    make('p', {}, `This page is for ${roles.map((role) => `${role}s`).join(' and ')}.`),
    ...(who.role === 'stranger' ? [] : [loggedIn(who)]),
    loginForm('Your token (enfilade serve token makes one)'));
  return undefined;
}
