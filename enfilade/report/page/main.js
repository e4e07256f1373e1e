'use strict';

// Puts the page together. What fails is said in its place and at the top, so that a test, or a
// reader, sees it. What is left out is said in one line at the end.

// Address, title, how it is drawn, and the data without which it is left out.
const kSections = [
  ['results', 'Results', drawResults, 'table'],
  ['training', 'Training', drawCurves, 'curves'],
  ['errors', 'Where agents stop', drawErrors, 'errors'],
  ['length', 'Success by path length', drawByLength, 'byLength'],
  ['episodes', 'Episodes', drawGallery, 'gallery'],
  ['plans', 'Floor plans', drawPlans, 'plans'],
  ['walks', 'Walks', drawWalks, 'walks'],
  ['examples', 'Instructions', drawExamples, 'examples'],
  ['buildings', 'Buildings', drawPanoramas, 'panoramas'],
  ['lengths', 'Lengths', drawLengths, 'lengths'],
  ['words', 'First words', drawWords, 'words'],
  ['settings', 'Settings', drawSettings, 'about'],
];

const failures = [];

function fail(where, error) {
  failures.push(`${where}: ${error && error.message ? error.message : error}`);
  const box = document.getElementById('failures');
  box.hidden = false;
  box.textContent = `Something on this page could not be drawn: ${failures.join('; ')}`;
  document.documentElement.dataset.failures = String(failures.length);
}

window.addEventListener('error', (event) => fail('script', event.error || event.message));
document.addEventListener('securitypolicyviolation', (event) =>
  fail('refused', `${event.violatedDirective} ${event.blockedURI}`));

function drawHead(about) {
  const head = document.getElementById('head');
  head.append(element('h1', {}, about.title));
  if (about.synthetic) {
    head.append(element('p', {class: 'synthetic'}, element('strong', {}, 'SYNTHETIC'),
      ' model homes: no figure here can be compared with a published one.'));
  }
  const facts = element('dl', {class: 'facts'});
  for (const [name, value] of about.facts) {
    facts.append(element('div', {}, element('dt', {}, name), element('dd', {}, value)));
  }
  head.append(facts);
}

// {"a": {"b": 1}} -> [["a.b", "1"]]
function flattened(value, prefix = '') {
  if (value === null || typeof value !== 'object') return [[prefix, String(value)]];
  if (Array.isArray(value)) return [[prefix, value.join(', ')]];
  return Object.entries(value)
    .flatMap(([key, child]) => flattened(child, prefix ? `${prefix}.${key}` : key));
}

function drawSettings(section, data) {
  if (data.about.models.length === 0) {
    leaveOut('Settings', 'No model was trained here.');
    return;
  }
  for (const model of data.about.models) {
    const body = element('tbody');
    for (const [name, value] of flattened(model.config)) {
      body.append(element('tr', {}, element('th', {scope: 'row'}, name), element('td', {}, value)));
    }
    section.append(element('details', {}, element('summary', {}, model.name),
      element('div', {class: 'scroll'}, element('table', {class: 'settings'}, body))));
  }
}

function drawPage() {
  const data = JSON.parse(document.getElementById('data').textContent);
  drawHead(data.about);
  const sections = document.getElementById('sections');
  const contents = document.getElementById('contents');
  for (const [id, title, draw, needs] of kSections) {
    if (!(needs in data)) continue;
    if (data[needs].missing) {
      leaveOut(title, data[needs].missing);
      continue;
    }
    const section = element('section', {id}, element('h2', {}, title));
    sections.append(section);  // before it is drawn, as some parts measure their size
    try {
      draw(section, data);
    } catch (error) {
      section.append(paragraph(`It could not be drawn: ${error.message}.`, 'missing'));
      fail(id, error);
    }
    if (section.childElementCount > 1) contents.append(element('a', {href: `#${id}`}, title));
    else section.remove();  // it is left out
  }
  const first = sections.querySelector('section');
  if (first) document.querySelector('.skip').setAttribute('href', `#${first.id}`);
  if (leftOut.size > 0) sections.append(leftOutLine());
  document.getElementById('foot').append('Made by Enfilade. Charts drawn with D3. ' +
    'This page is one file and loads nothing.');
}

drawPage();
document.documentElement.dataset.ready = 'yes';
