'use strict';

// The first four words of instructions, from the inside out (the paper's figure).

const kSunburstColours = ['#8fc3e8', '#f3b27a', '#93d3ae', '#e7a1bf', '#d9cf7c', '#b9aee6',
  '#9ad6d6', '#e3a493', '#c3cf9b', '#c8b8a6'];

function sunburstTree(words) {
  const root = d3.hierarchy(words, (branch) => branch.next);
  // A branch's own share is what its shown branches don't take.
  root.each((node) => {
    const shown = d3.sum(node.children || [], (child) => child.data.count);
    node.value = 0;
    node.own = Math.max(0, node.data.count - shown);
  });
  root.eachAfter((node) => {
    node.value = node.own + d3.sum(node.children || [], (child) => child.value);
  });
  return d3.partition().size([2 * Math.PI, 5])(root);
}

const phraseOf = (node) =>
  node.ancestors().reverse().slice(1).map((n) => n.data.word).join(' ');

function topBranch(node) {
  return node.depth <= 1 ? node : topBranch(node.parent);
}

// A word fits if its ring is thick enough and its arc wide enough.
function labelPlace(node, ring) {
  const angle = (node.x0 + node.x1) / 2 * 180 / Math.PI;
  const radius = (node.y0 + node.y1) / 2 * ring;
  const wide = (node.x1 - node.x0) * radius;
  if (wide < 11 || node.data.word.length * 6.4 > ring - 4) return null;
  return `rotate(${angle - 90}) translate(${radius},0) rotate(${angle < 180 ? 0 : 180})`;
}

function showPhrase(centre, node, total) {
  centre.selectAll('tspan').remove();
  const lines = node ? [...splitPhrase(phraseOf(node)), percent(node.data.count / total, 1)]
    : ['first four', 'words'];
  lines.forEach((line, i) => {
    centre.append('tspan').attr('x', 0).attr('dy', i === 0 ? `${-0.55 * (lines.length - 2)}em` : '1.2em')
      .text(line);
  });
}

function splitPhrase(phrase) {
  const words = phrase.split(' ');
  return words.length < 3 ? [phrase] : [words.slice(0, 2).join(' '), words.slice(2).join(' ')];
}

function sunburst(words) {
  const size = 600;
  const ring = (size / 2 - 4) / 5;
  const root = sunburstTree(words);
  const svg = d3.create('svg').attr('class', 'sunburst').attr('role', 'img')
    .attr('viewBox', `${-size / 2} ${-size / 2} ${size} ${size}`)
    .attr('aria-label', 'Sunburst of the first four words of instructions; the table beside it ' +
      'has the most frequent ones');
  const arc = d3.arc().startAngle((n) => n.x0).endAngle((n) => n.x1)
    .innerRadius((n) => n.y0 * ring).outerRadius((n) => n.y1 * ring - 1);
  const centre = svg.append('text').attr('class', 'phrase').attr('text-anchor', 'middle');
  const tops = root.children || [];
  for (const node of root.descendants().slice(1)) {
    const colour = kSunburstColours[tops.indexOf(topBranch(node)) % kSunburstColours.length];
    // Paler outside; never through to the page, so that dark words can be read on dark pages too.
    svg.append('path').attr('d', arc(node))
      .attr('fill', d3.interpolateRgb(colour, '#fff')(0.17 * (node.depth - 1)))
      .on('mouseenter', () => showPhrase(centre, node, words.count))
      .on('mouseleave', () => showPhrase(centre, null, words.count))
      .append('title').text(`${phraseOf(node)}: ${node.data.count}`);
    const place = labelPlace(node, ring);
    if (place) {
      svg.append('text').attr('class', 'word').attr('text-anchor', 'middle').attr('dy', '.35em')
        .attr('transform', place).text(node.data.word);
    }
  }
  showPhrase(centre, null, words.count);
  return svg.node();
}

function commonPhrases(words) {
  const leaves = d3.hierarchy(words, (branch) => branch.next).descendants()
    .filter((node) => node.depth === 4).sort((a, b) => b.data.count - a.data.count).slice(0, 12);
  const body = element('tbody');
  for (const leaf of leaves) {
    body.append(element('tr', {}, element('td', {}, phraseOf(leaf)),
      element('td', {}, String(leaf.data.count)),
      element('td', {}, percent(leaf.data.count / words.count, 1))));
  }
  const head = element('tr', {}, element('th', {scope: 'col'}, 'begins with'),
    element('th', {scope: 'col'}, 'instructions'), element('th', {scope: 'col'}, 'share'));
  return element('table', {}, element('thead', {}, head), body);
}

function drawWords(section, data) {
  section.append(paragraph(`How the ${data.words.count.toLocaleString('en')} instructions begin: ` +
    'first word inside, fourth outside. Beginnings of less than 0.3 % are left blank.', 'lead'));
  section.append(element('div', {class: 'two'}, element('figure', {}, sunburst(data.words)),
    element('div', {class: 'scroll'}, commonPhrases(data.words))));
}
