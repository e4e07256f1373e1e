/** The first page: what this is, a look into a building, what one can do here, and all buildings. */
import { icon, type IconName } from '../elements/icons.ts';
import { addHeader, byId, counted, empty, make, run, type Served } from '../elements/page.ts';
import { api } from '../server/api.ts';
import { formatLink, type Place } from '../viewer/deep_link.ts';
import { loadFaces, loadSweep, type Look, TurningPanorama } from '../viewer/turning_panorama.ts';

interface Building {
  readonly scan: string;
  readonly viewpoints: number;
  readonly edges: number;
  readonly storeys: number;
  readonly rooms?: number;
  readonly instructions: number;
  readonly pictures: boolean;
  /** Whether it has a navigation mesh to walk on. */
  readonly roam: boolean;
}
interface ScanList extends Served {
  readonly scans: readonly Building[];
}
interface Outlook extends Look {
  readonly viewpoint: string;
}

const pathOf = (scan: string): string => `scans/${encodeURIComponent(scan)}`;
const houseOf = (scan: string): string => `/roam?view=house${formatLink({ scan })}`;
const pictureOf = (scan: string, width: 640 | 1280): string => `/api/v1/${pathOf(scan)}/picture.jpg?width=${width}`;

function doors({ runs = false }: Served, explore: HTMLAnchorElement): HTMLElement {
  const door = (name: IconName, link: HTMLElement, text: string) => make('li', {}, icon(name), make('h2', {}, link), make('p', {}, text));
  const to = (href: string, title: string) => make('a', { href }, title);
  return make('ul', { class: 'doors', 'aria-label': 'What you can do here' },
    door('explore', explore, 'Go through a building from viewpoint to viewpoint, with its map.'),
    door('walk', to('/try', 'Follow an instruction'), 'With an agent’s view and actions. At the end you see how far from the goal you stopped.'),
    door('play', to('/play', 'Play as a model'), 'The observations and actions of a language model, as text or as marked pictures.'),
    ...(runs ? [door('runs', to('/replay', 'Runs of models'), 'Observation, response and action of each step, and how it ended.')] : []),
    door('write', to('/organise', 'Collect instructions'), 'Have people write or follow them: a study with consent, review and export.'),
    door('compete', to('/leaderboard', 'Leaderboard'), 'Submit the results of an agent, and see how it ranks.'));
}

function cardOf({ scan, viewpoints, storeys, rooms, instructions, pictures, roam }: Building): HTMLElement {
  const plan = `/api/v1/${pathOf(scan)}/plan.svg`;
  const picture = make('img', {
    src: pictures ? pictureOf(scan, 640) : plan, alt: '', loading: 'lazy', class: pictures ? 'card-picture' : 'card-picture plan',
    width: '640', height: '400',
  });
  const size = [...(rooms === undefined ? [] : [counted(rooms, 'room')]), counted(storeys, 'storey'), counted(viewpoints, 'viewpoint')];
  const links = make('p', { class: 'card-links' },
    ...(roam ? [make('a', { href: `/roam${formatLink({ scan })}`, 'aria-label': `Walk anywhere in ${scan}` }, 'Walk anywhere'),
      make('a', { href: houseOf(scan), 'aria-label': `Doll’s house of ${scan}` }, 'Doll’s house')] : []),
    ...(pictures ? [make('a', { href: plan, 'aria-label': `Plan of ${scan}` }, 'Plan'),
      make('a', { href: `/verify${formatLink({ scan })}`, 'aria-label': `Verify graph of ${scan}` }, 'Verify graph')] : []));
  return make('li', { class: 'card' }, picture, make('div', { class: 'card-body' },
    make('h3', {}, make('a', { href: pictures ? `/view${formatLink({ scan })}` : plan }, scan)),
    make('p', {}, size.join(', ')),
    make('p', { class: 'note' }, `${instructions === 0 ? 'No instructions' : counted(instructions, 'instruction')}${pictures ? '' : ', no pictures'}`),
    links));
}

/** Turns the picture into a panorama, once the page stands. Returns it, where people want to see things move. */
async function turn(hero: HTMLElement, scan: string, outlook: Outlook): Promise<TurningPanorama | undefined> {
  if (matchMedia('(prefers-reduced-motion: reduce)').matches) return undefined;
  const { viewpoints } = await api.scan(scan);
  const rotation = viewpoints.find(({ id }) => id === outlook.viewpoint)?.rotation;
  if (!rotation) return undefined;
  const [faces, sweep] = await Promise.all([loadFaces(api, scan, outlook.viewpoint), loadSweep(api, scan, outlook.viewpoint, rotation, outlook)]);
  const panorama = new TurningPanorama(outlook, rotation, faces, sweep);
  hero.querySelector('.scene')!.append(panorama.element);
  // WCAG 2.2.2: what moves by itself can be stopped.
  const button = make('button', { type: 'button' }, 'Pause');
  button.addEventListener('click', () => {
    if (panorama.playing) panorama.pause();
    else panorama.play();
    button.textContent = panorama.playing ? 'Pause' : 'Turn';
  });
  hero.querySelector('.turning')!.prepend(button);
  return panorama;
}

function heroOf(building: Building | undefined, explore: HTMLAnchorElement, walk: HTMLAnchorElement): HTMLElement {
  const plate = make('div', { class: 'plate' }, make('h1', {}, 'Find the way by words'),
    make('p', { class: 'lead' }, 'Enfilade is a platform for vision-and-language navigation: buildings to walk through, instructions to follow, and a leaderboard for the agents that try.'));
  const hero = make('section', { class: 'hero', 'aria-label': 'About Enfilade' }, plate);
  if (!building) return hero;
  const { scan, roam } = building;
  plate.append(make('p', { class: 'buttons' }, explore, ...(roam ? [walk, make('a', { href: houseOf(scan), class: 'button' }, 'Doll’s house')] : [])),
    make('p', { class: 'note' }, 'Explore goes from viewpoint to viewpoint, as agents do.',
      ...(roam ? [' Walk anywhere is a continuous walk on the floor, and begins in the same place.'] : [])));
  hero.append(make('div', { class: 'scene' }, make('img', { src: pictureOf(scan, 1280), alt: '', fetchpriority: 'high' })),
    make('div', { class: 'turning' }, make('span', {}, scan)));
  return hero;
}

run(async () => {
  const served = await api.call<ScanList>('scans');
  addHeader(served);
  const { scans } = served;
  const main = byId('main');
  const first = scans.find(({ pictures }) => pictures);
  // All three begin where the picture above them is, looking the same way.
  const begin = (text: string, attributes: Record<string, string> = {}) => make('a', { href: '#buildings', ...attributes }, text);
  const [explore, walk, door] = [
    begin('Explore from here', { class: 'button main' }), begin('Walk anywhere', { class: 'button' }), begin('Explore a building')];
  const aim = (place: Place) => {
    explore.href = door.href = `/view${formatLink(place)}`;
    walk.href = `/roam${formatLink(place)}`;
  };
  if (first) aim({ scan: first.scan });
  const hero = heroOf(first, explore, walk);
  main.append(hero, doors(served, door), make('h2', { id: 'buildings' }, 'Buildings'),
    scans.length === 0 ? empty('No buildings', 'This data set has no buildings.') : make('ul', { class: 'cards' }, ...scans.map(cardOf)));
  if (!first) return;
  const outlook = await api.call<Outlook>(`${pathOf(first.scan)}/outlook`).catch(() => undefined);
  if (!outlook) return; // the picture stays
  const { viewpoint, heading, elevation } = outlook;
  const place = { scan: first.scan, viewpoint, elevation };
  aim({ ...place, heading });
  // After the first view: the panorama's six pictures would come before those of the cards otherwise.
  if (document.readyState !== 'complete') await new Promise((loaded) => { addEventListener('load', loaded, { once: true }); });
  const panorama = await turn(hero, first.scan, outlook).catch(() => undefined);
  if (!panorama) return;
  for (const link of [explore, walk, door]) {
    for (const kind of ['pointerdown', 'click', 'focus']) link.addEventListener(kind, () => aim({ ...place, heading: panorama.heading }));
  }
});
