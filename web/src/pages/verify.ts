/**
 * Checking a graph by hand, the paper's manual verification: plan and view side by side, edges added
 * and taken away with a reason, written as a corrections file: `/verify#scan/viewpoint`.
 */
import { lacksGraphics } from '../elements/graphics.ts';
import { noBuilding, showInstead } from '../elements/instead.ts';
import { addHeader, byId, crumbs, make, run, table } from '../elements/page.ts';
import { directionTo, norm, subtract } from '../geometry/geometry.ts';
import {
  type Action, applyCorrections, type Correction, correctionsFile, keepCorrections, keptCorrections,
} from '../scan/corrections.ts';
import { namesByViewpoint, type Scan, viewpointIndex } from '../scan/scan.ts';
import { api } from '../server/api.ts';
import { usualElevation } from '../viewer/arrival.ts';
import { formatLink, parseLink } from '../viewer/deep_link.ts';
import type { Mark } from '../viewer/discs.ts';
import { MiniMap, type Viewer } from '../viewer/enfilade-viewer.ts';
import { openNamed } from '../viewer/open_named.ts';

/** The paper's limit between viewpoints, metres. */
const longestEdge = 5;

declare global {
  interface Window {
    verifier?: Verifier;
  }
}

/** An edge that is, or that could be. */
interface Candidate {
  readonly viewpoint: number;
  readonly distance: number;
  readonly there: boolean;
}

class Verifier {
  readonly viewer: Viewer;
  private readonly original: Scan;
  private readonly map: MiniMap;
  private readonly edges = make('div');
  private readonly list = make('div');
  private readonly who = make('input', { id: 'who', type: 'text', maxlength: '80' });
  private readonly why = make('input', { id: 'why', type: 'text', maxlength: '200' });
  private readonly said = make('p', { role: 'status' });
  private corrections: Correction[];
  private standing = -1;

  constructor(viewer: Viewer, map: MiniMap, panel: HTMLElement) {
    this.viewer = viewer;
    this.map = map;
    this.original = viewer.scan;
    this.corrections = keptCorrections(viewer.scan.scan);
    this.who.value = localStorage.getItem('enfilade-who') ?? '';
    this.who.addEventListener('input', () => localStorage.setItem('enfilade-who', this.who.value));
    const save = make('button', { type: 'button', class: 'main' }, 'Download the corrections');
    save.addEventListener('click', () => this.save());
    panel.append(
      make('label', { for: 'who' }, 'Your name'), this.who,
      make('label', { for: 'why' }, 'Reason: a rope, a glass door, a step'), this.why, this.said,
      make('h2', {}, 'Edges from here'), this.edges,
      make('h2', {}, 'Corrections'), this.list, make('p', {}, save));
    viewer.onChange(({ viewpoint }) => {
      if (viewpoint !== this.standing) this.show();
    });
    this.apply();
  }

  private candidates(): Candidate[] {
    const { viewpoints, storeys } = this.viewer.scan;
    const here = this.viewer.pose.viewpoint;
    const from = viewpoints[here]!;
    const storey = storeys.find((s) => s.viewpoints.includes(here));
    return viewpoints
      .map((to, viewpoint) => ({
        viewpoint,
        distance: norm(subtract(to.position, from.position)),
        there: from.neighbours.includes(viewpoint),
      }))
      .filter(({ viewpoint, distance, there }) =>
        viewpoint !== here && viewpoints[viewpoint]!.included &&
        (there || (distance <= longestEdge && (storey?.viewpoints.includes(viewpoint) ?? false))))
      .sort((a, b) => Number(b.there) - Number(a.there) || a.distance - b.distance);
  }

  private apply(): void {
    keepCorrections(this.original.scan, this.corrections);
    this.viewer.setGraph(applyCorrections(this.original, this.corrections));
    this.map.redraw();
    this.show();
  }

  private show(): void {
    this.standing = this.viewer.pose.viewpoint;
    const candidates = this.candidates();
    const marks = candidates.filter(({ there }) => !there).map(({ viewpoint }) => [viewpoint, 'candidate'] as const);
    this.viewer.setMarks(new Map<number, Mark>(marks));
    this.point(undefined);
    const edges = table(['To', 'Metres', ''], candidates.map((c) => this.row(c)), { label: 'Edges from here' });
    edges.querySelectorAll('tbody tr').forEach((row, k) => this.pointFrom(row as HTMLElement, candidates[k]!.viewpoint));
    this.edges.replaceChildren(edges, this.exclusion());
    this.list.replaceChildren(this.corrections.length === 0 ? make('p', {}, 'None yet.') : this.history());
  }

  /** A row shows which disc and which dot are its viewpoint's, while it is pointed at or has the focus. */
  private pointFrom(row: HTMLElement, viewpoint: number): void {
    for (const begin of ['pointerenter', 'focusin']) row.addEventListener(begin, () => this.point(viewpoint));
    for (const end of ['pointerleave', 'focusout']) row.addEventListener(end, () => this.point(undefined));
  }

  private point(viewpoint: number | undefined): void {
    this.viewer.highlight(viewpoint);
    this.map.setMarked(viewpoint === undefined ? [] : [viewpoint]);
  }

  private row({ viewpoint, distance, there }: Candidate): (Node | string)[] {
    const { position } = this.viewer.scan.viewpoints[viewpoint]!;
    const name = this.viewer.name(viewpoint);
    const look = make('button', { type: 'button', class: 'wraps' }, `Viewpoint ${viewpoint}${name ? `, ${name}` : ''}`);
    look.addEventListener('click', () => {
      const from = this.viewer.scan.viewpoints[this.viewer.pose.viewpoint]!.position;
      this.viewer.look(directionTo(from, position).heading, usualElevation);
    });
    const change = make('button', { type: 'button', 'aria-label': `${there ? 'Remove' : 'Add'} the edge to viewpoint ${viewpoint}` }, there ? 'Remove' : 'Add');
    change.addEventListener('click', () => this.add(there ? 'remove-edge' : 'add-edge', viewpoint));
    return [look, make('td', { class: 'number' }, distance.toFixed(1)), change];
  }

  private exclusion(): HTMLElement {
    const out = !this.viewer.scan.viewpoints[this.viewer.pose.viewpoint]!.included;
    const button = make('button', { type: 'button' }, out ? 'Include this viewpoint' : 'Exclude this viewpoint');
    button.addEventListener('click', () => this.add(out ? 'include' : 'exclude'));
    return make('p', {}, button);
  }

  private history(): HTMLElement {
    const name = (id: string | undefined) => viewpointIndex(this.original, id);
    const rows = this.corrections.map(({ action, from, to, who, why }, k) => {
      const undo = make('button', { type: 'button', 'aria-label': `Undo correction ${k + 1}` }, 'Undo');
      undo.addEventListener('click', () => {
        this.corrections = this.corrections.filter((_, n) => n !== k);
        this.apply();
      });
      return [`${action} ${name(from)}${to ? ` – ${name(to)}` : ''}`, `${why} (${who})`, undo];
    });
    return table(['What', 'Why', ''], rows);
  }

  private add(action: Action, to?: number): void {
    const [who, why] = [this.who.value.trim(), this.why.value.trim()];
    this.said.className = who && why ? 'done' : 'problem';
    this.said.textContent = who && why ? 'Correction added.' : 'Write your name, and the reason.';
    if (!who || !why) return void (who ? this.why : this.who).focus();
    const id = (viewpoint: number) => this.original.viewpoints[viewpoint]!.id;
    this.corrections = [...this.corrections, {
      action,
      from: id(this.viewer.pose.viewpoint),
      ...(to !== undefined && { to: id(to) }),
      who,
      why,
      when: new Date().toISOString().slice(0, 19) + 'Z',
    }];
    this.apply();
  }

  private save(): void {
    const { scan } = this.original;
    const file = new Blob([correctionsFile(scan, this.corrections)], { type: 'application/json' });
    const link = make('a', { href: URL.createObjectURL(file), download: `${scan}_corrections.json` });
    link.click();
    URL.revokeObjectURL(link.href);
  }
}

run(async () => {
  if (lacksGraphics()) return;
  const place = parseLink(location.hash);
  if (!place) return showInstead('Verify a graph', noBuilding(undefined));
  const [view, side, mapBox] = [make('div', { class: 'view' }), make('aside', { class: 'side' }), make('div', { class: 'map' })];
  side.append(mapBox);
  byId('main').append(view, side);
  const viewer = await openNamed(view, place, { name: 'Verify a graph', path: '/verify' });
  if (!viewer) return;
  addHeader(viewer.scan);
  const map = new MiniMap(viewer, { numbers: true });
  const plan = await api.plan(place.scan).catch(() => undefined); // a map without walls
  if (plan) {
    map.setPlan(plan);
    viewer.setNames(namesByViewpoint(plan));
  }
  const panel = make('div', { class: 'panel' }, crumbs([['/', 'Buildings'], [`/view${formatLink({ scan: place.scan })}`, place.scan]], 'Verify'),
    make('h1', {}, `Verify ${place.scan}`),
    make('p', { class: 'note' }, 'White discs are edges. Orange ones are viewpoints near by without an edge. Apply the saved file with enfilade homes --corrections.'));
  mapBox.append(map.element);
  side.append(panel);
  window.verifier = new Verifier(viewer, map, panel);
});
