/** The buildings. */
import { formatLink } from '../deep_link.ts';
import { addHeader, api, byId, make, run } from '../page.ts';

interface ScanList {
  readonly synthetic: boolean;
  readonly scans: readonly {
    readonly scan: string;
    readonly viewpoints: number;
    readonly edges: number;
    readonly pictures: boolean;
  }[];
}

run(async () => {
  const { synthetic, scans } = await api.call<ScanList>('scans');
  addHeader(synthetic);
  const cards = scans.map(({ scan, viewpoints, edges, pictures }) => {
    const plan = make('img', { src: `/api/v1/scans/${scan}/plan.svg`, alt: '', loading: 'lazy' });
    const text = make('span', {}, make('strong', {}, scan), make('br'),
      `${viewpoints} viewpoints, ${edges} edges${pictures ? '' : ', no pictures'}`);
    const href = pictures ? `/view${formatLink({ scan })}` : `/api/v1/scans/${scan}/plan.svg`;
    const card = make('li', {}, make('a', { href }, plan, text));
    if (pictures) card.append(make('a', { href: `/verify${formatLink({ scan })}`, class: 'small' }, 'Verify its graph'));
    return card;
  });
  byId('main').append(
    make('h1', {}, 'Buildings'),
    make('p', { class: 'note' }, 'Walk through a building as an agent sees it.'),
    make('ul', { class: 'cards' }, ...cards),
  );
});
