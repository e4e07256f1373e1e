/** The first page: what this is, a look into a building, four doors, and all buildings. */
import { icon, type IconName } from '../elements/icons.ts';
import { addHeader, byId, counted, empty, make, run, type Served } from '../elements/page.ts';
import { api } from '../server/api.ts';
import { formatLink } from '../viewer/deep_link.ts';
import { loadFaces, type Look, TurningPanorama } from '../viewer/turning_panorama.ts';

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
const pictureOf = (scan: string, width: 640 | 1280): string => `/api/v1/${pathOf(scan)}/picture.jpg?width=${width}`;

function doors(first: string | undefined): HTMLElement {
  const door = (name: IconName, title: string, href: string, text: string) => make('li', {}, icon(name),
    make('h2', {}, make('a', { href }, title)), make('p', {}, text));
  return make('ul', { class: 'doors', 'aria-label': 'What you can do here' },
    door('explore', 'Explore', first === undefined ? '#buildings' : `/view${formatLink({ scan: first })}`, 'Walk through a building from viewpoint to viewpoint, with its map.'),
    door('write', 'Write', '/organise', 'Have people describe paths: a study with consent, review and export.'),
    door('walk', 'Walk', '/try', 'Follow an instruction as an agent does, and see how far from the goal you stop.'),
    door('compete', 'Compete', '/leaderboard', 'Submit the results of an agent, and see how it ranks.'));
}

function cardOf({ scan, viewpoints, storeys, rooms, instructions, pictures, roam }: Building): HTMLElement {
  const plan = `/api/v1/${pathOf(scan)}/plan.svg`;
  const picture = make('img', {
    src: pictures ? pictureOf(scan, 640) : plan, alt: '', loading: 'lazy', class: pictures ? 'card-picture' : 'card-picture plan',
    width: '640', height: '400',
  });
  const size = [...(rooms === undefined ? [] : [counted(rooms, 'room')]), counted(storeys, 'storey'), counted(viewpoints, 'viewpoint')];
  const links = make('p', { class: 'card-links' },
    ...(roam ? [make('a', { href: `/roam${formatLink({ scan })}`, 'aria-label': `Walk anywhere in ${scan}` }, 'Walk anywhere')] : []), ...(pictures ? [make('a', { href: plan, 'aria-label': `Plan of ${scan}` }, 'Plan'),
    make('a', { href: `/verify${formatLink({ scan })}`, 'aria-label': `Verify graph of ${scan}` }, 'Verify graph')] : []));
  return make('li', { class: 'card' }, picture, make('div', { class: 'card-body' },
    make('h3', {}, make('a', { href: pictures ? `/view${formatLink({ scan })}` : plan }, scan)),
    make('p', {}, size.join(', ')),
    make('p', { class: 'note' }, `${instructions === 0 ? 'No instructions' : counted(instructions, 'instruction')}${pictures ? '' : ', no pictures'}`),
    links));
}

/** Turns the picture into a panorama, once the page stands. */
async function turn(hero: HTMLElement, scan: string): Promise<void> {
  if (matchMedia('(prefers-reduced-motion: reduce)').matches) return;
  const [outlook, { viewpoints }] = await Promise.all([api.call<Outlook>(`${pathOf(scan)}/outlook`), api.scan(scan)]);
  const rotation = viewpoints.find(({ id }) => id === outlook.viewpoint)?.rotation;
  if (!rotation) return;
  const panorama = new TurningPanorama(outlook, rotation, await loadFaces(api, scan, outlook.viewpoint));
  hero.querySelector('.scene')!.append(panorama.element);
  // WCAG 2.2.2: what moves by itself can be stopped.
  const button = make('button', { type: 'button' }, 'Pause');
  button.addEventListener('click', () => {
    if (panorama.playing) panorama.pause();
    else panorama.play();
    button.textContent = panorama.playing ? 'Pause' : 'Turn';
  });
  hero.querySelector('.turning')!.prepend(button);
}

function heroOf(building: Building | undefined): HTMLElement {
  const scene = make('div', { class: 'scene' });
  const plate = make('div', {}, make('h1', {}, 'Find the way by words'),
    make('p', { class: 'lead' }, 'Enfilade is a platform for vision-and-language navigation: buildings to walk through, instructions to follow, and a leaderboard for the agents that try.'));
  const hero = make('section', { class: 'hero', 'aria-label': 'About Enfilade' }, scene, make('div', { class: 'plate' }, plate));
  if (!building) return hero;
  const view = `/view${formatLink({ scan: building.scan })}`;
  plate.append(make('p', { class: 'buttons' }, make('a', { href: view, class: 'button main' }, 'Walk in'), make('a', { href: '#buildings', class: 'button' }, 'All buildings')));
  scene.append(make('img', { src: pictureOf(building.scan, 1280), alt: '', fetchpriority: 'high' }));
  hero.append(make('div', { class: 'turning' }, make('span', {}, building.scan)));
  return hero;
}

run(async () => {
  const served = await api.call<ScanList>('scans');
  addHeader(served);
  const { scans } = served;
  const main = byId('main');
  const first = scans.find(({ pictures }) => pictures);
  const hero = heroOf(first);
  main.classList.add('first');
  main.append(hero, doors(first?.scan), make('h2', { id: 'buildings' }, 'Buildings'),
    scans.length === 0 ? empty('No buildings', 'This data set has no buildings.') : make('ul', { class: 'cards' }, ...scans.map(cardOf)));
  if (!first) return;
  // After the first view: the panorama's six pictures would come before those of the cards otherwise.
  if (document.readyState !== 'complete') await new Promise((loaded) => { addEventListener('load', loaded, { once: true }); });
  await turn(hero, first.scan).catch(() => {}); // the picture stays
});
