// Checks what a study page decides, without a browser: study_page.js INDEX_HTML ANSWERS_DIR.
// Writes the answers of three respondents as the page would save them.
'use strict';
const assert = require('assert');
const fs = require('fs');
const path = require('path');
const vm = require('vm');

const [page, folder] = process.argv.slice(2);
const html = fs.readFileSync(page, 'utf8');
const element = id => html.match(new RegExp(`<script id="${id}"[^>]*>([\\s\\S]*?)</script>`))[1];
const study = JSON.parse(element('study'));
const Logic = vm.runInNewContext(element('logic') + '\nLogic');
for (const script of html.matchAll(/<script>([\s\S]*?)<\/script>/g)) new vm.Script(script[1]);  // it parses

const codes = t => t.cards.map(c => c.code);
const plain = value => JSON.parse(JSON.stringify(value));

// Every respondent sees every case with every card once; the same one sees the same order again.
const orders = new Set();
const places = new Map();
for (let i = 0; i < 400; ++i) {
  const trials = plain(Logic.plan(study, 'r' + i));
  assert.deepStrictEqual(trials.map(t => t.case).sort(), study.trials.map(t => t.case).sort());
  for (const t of trials) {
    const original = study.trials.find(s => s.case === t.case);
    assert.deepStrictEqual(codes(t).sort(), codes(original).sort());
    places.set(t.cards[0].code, (places.get(t.cards[0].code) || 0) + 1);
  }
  orders.add(JSON.stringify(trials.map(codes)));
  assert.deepStrictEqual(plain(Logic.plan(study, 'r' + i)), trials);
}
assert(orders.size > 4, 'orders differ between respondents');
// Two cards a case: each stands first for about half of 400 respondents (five standard deviations are 50).
for (const n of places.values()) assert(Math.abs(n - 200) < 50, 'first places: ' + n);

// Keys.
assert.deepStrictEqual(plain(Logic.keyAction('2', 3)), { choose: 1 });
assert.strictEqual(Logic.keyAction('4', 3), null);
assert.strictEqual(Logic.keyAction('0', 3), null);
assert.deepStrictEqual(plain(Logic.keyAction('Enter', 3)), { go: 1 });
assert.deepStrictEqual(plain(Logic.keyAction('Backspace', 3)), { go: -1 });
assert.deepStrictEqual(plain(Logic.keyAction(' ', 3)), { replay: true });

// Forward only with an answer, never before the first trial or beyond the end.
const trials = plain(Logic.plan(study, 'r'));
assert.strictEqual(Logic.go(0, 1, trials, {}), 0);
assert.strictEqual(Logic.go(0, 1, trials, { [trials[0].case]: 'x' }), 1);
assert.strictEqual(Logic.go(0, -1, trials, {}), 0);
assert.strictEqual(Logic.go(trials.length, 1, trials, {}), trials.length);

// A failed result has a card and no video.
assert(study.trials.some(t => t.cards.some(c => !c.video)));
assert.strictEqual(Logic.fileName('Ada L. / 3'), 'answers-Ada-L-3.json');

fs.mkdirSync(folder, { recursive: true });
['Ada', 'Ben', 'Eve'].forEach((name, h) => {
  const trials = Logic.plan(study, name), choices = {};
  for (const t of trials) choices[t.case] = t.cards[h % t.cards.length].code;
  fs.writeFileSync(path.join(folder, Logic.fileName(name)), JSON.stringify(Logic.answers(study, name, trials, choices)));
});
