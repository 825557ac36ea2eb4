// Drives the planner as a surgeon would, in Chromium: create, plan, simulate, watch, compare,
// download. Usage: node planner_test.mjs PROGRAM WEB_FOLDER [SCREENSHOT_FOLDER]. Skips with 77.
import assert from 'node:assert/strict';
import { execFileSync, spawn } from 'node:child_process';
import fs from 'node:fs';
import { createRequire } from 'node:module';
import os from 'node:os';
import path from 'node:path';

const [program, web, shots] = process.argv.slice(2);
const chromiumPath = '/usr/bin/chromium';
if (!fs.existsSync(chromiumPath) || !fs.existsSync(path.join(web, 'node_modules/playwright-core'))) {
  console.log('skipped: /usr/bin/chromium or playwright-core is not installed');
  process.exit(77);
}
const require = createRequire(path.join(path.resolve(web), 'package.json'));
const { chromium } = require('playwright-core');
const axe = fs.readFileSync(require.resolve('axe-core/axe.min.js'), 'utf8');
const flags = ['--no-sandbox', '--no-first-run', '--disable-quic', '--disable-background-networking', '--disable-component-update',
  '--disable-sync', '--disable-default-apps', '--disable-extensions', '--mute-audio', '--disable-gpu', '--enable-unsafe-swiftshader'];
/** Coarse enough for a test; everything else is as the page asks for it. */
const quick = { 'mesh.target_vertices': '1500', 'mesh.near_edge_mm': '8', 'segment.spacing_mm': '2', 'heal.days': '24', 'mesh.preset': 'standard' };
const minutes = (n) => n * 60_000;

const folder = fs.mkdtempSync(path.join(os.tmpdir(), 'planner-'));
const server = spawn(program, ['serve', '--cases', path.join(folder, 'cases'), '--port', '0', '--json'],
  { stdio: ['ignore', 'pipe', 'inherit'], env: { ...process.env, OMP_NUM_THREADS: '1', OPENBLAS_NUM_THREADS: '1' } });
const address = await new Promise((resolve, reject) => {
  server.stdout.once('data', (data) => resolve(JSON.parse(data).address));
  server.once('exit', () => reject(new Error('the server ended')));
});
let browser;
const problems = [];

async function open(extra = [], size = { width: 1400, height: 860 }) {
  browser = await chromium.launch({ executablePath: chromiumPath, args: [...flags, ...extra] });
  const context = await browser.newContext({ viewport: size, acceptDownloads: true });
  const page = await context.newPage();
  page.setDefaultTimeout(minutes(1));
  page.on('console', (m) => { if (m.type() === 'error') problems.push(m.text()); });
  page.on('pageerror', (e) => problems.push(e.message));
  // A slow machine must not look like an idle user, from whom the page covers itself.
  await page.addInitScript(() => setInterval(() => dispatchEvent(new Event('pointermove')), 20_000));
  await page.goto(address);
  return page;
}
/** Mean, spread and a fingerprint of what the 3-D canvas shows. */
async function pixels(page) {
  await page.waitForTimeout(700);
  return page.evaluate(() => {
    const gl = document.querySelector('.viewer canvas');
    const copy = document.createElement('canvas');
    [copy.width, copy.height] = [200, 140];
    const context = copy.getContext('2d', { willReadFrequently: true });
    context.drawImage(gl, 0, 0, 200, 140);
    const data = context.getImageData(0, 0, 200, 140).data;
    let sum = 0, squares = 0, hash = 0;
    for (let i = 0; i < data.length; i += 4) {
      sum += data[i]; squares += data[i] * data[i];
      hash = (hash * 31 + data[i] + 7 * data[i + 1] + 13 * data[i + 2]) | 0;
    }
    const n = data.length / 4, mean = sum / n;
    return { lost: gl.getContext('webgl2').isContextLost(), spread: Math.sqrt(squares / n - mean * mean), hash };
  });
}
async function assertPicture(page, what) {
  const seen = await pixels(page);
  assert.equal(seen.lost, false, `${what}: the graphics context is lost`);
  assert.ok(seen.spread > 10, `${what}: the view is blank (spread ${seen.spread})`);
  return seen.hash;
}
async function accessible(page, where) {
  await page.evaluate(axe);
  const { violations } = await page.evaluate(() => window.axe.run(document, { resultTypes: ['violations'] }));
  const serious = violations.filter((v) => ['serious', 'critical'].includes(v.impact));
  assert.deepEqual(serious.map((v) => `${v.id}: ${v.nodes.map((n) => n.target).join(' ')}`), [], `axe on ${where}`);
}
const shot = async (page, name) => { if (shots) await page.screenshot({ path: path.join(shots, `${name}.png`) }); };
const excised = async (page) => Number((await page.textContent('.numbers .big strong')).replace(/[^0-9.]/g, ''));
async function settled(page) {
  await page.waitForFunction(() => {
    const numbers = document.querySelector('.numbers');
    return numbers?.dataset.live === 'false' && numbers.getAttribute('aria-busy') === 'false';
  });
}
async function slide(page, label, presses, key = 'ArrowRight') {
  const slider = page.getByRole('slider', { name: label });
  await slider.focus();
  for (let i = 0; i < presses; ++i) await page.keyboard.press(key);
  await page.waitForTimeout(300);
  await settled(page);
}
async function simulate(page) {
  await page.click('#simulate');
  await page.waitForSelector('.progress [role=progressbar]');
  await shot(page, 'progress');
  await page.waitForSelector('text=Volume of the operated region', { timeout: minutes(6) });
  await page.waitForFunction(() => !document.querySelector('.progress'), null, { timeout: minutes(6) });
}

async function createAndPlan(page) {
  await page.waitForSelector('text=No cases yet');
  await accessible(page, 'the empty list');
  await page.route('**/api/cases', (route) => {
    const body = route.request().postDataJSON();
    if (route.request().method() !== 'POST') return route.continue();
    return route.continue({ postData: JSON.stringify({ ...body, set: quick }) });
  });
  await page.click('text=New case');
  await accessible(page, 'the new case');
  await shot(page, 'new-case');
  await page.fill('dialog input[type=text]', '<img src=x onerror=alert(1)>');
  await page.fill('dialog input[type=text]', 'walk-through');
  await page.click('dialog button[type=submit]');
  await page.waitForSelector('.coming');
  await shot(page, 'creating');
  await page.waitForSelector('.case-link', { timeout: minutes(6) });
  await page.waitForFunction(() => !document.querySelector('.state.working'), null, { timeout: minutes(6) });
  assert.equal(await page.locator('main img, main canvas').count(), 0, 'no pictures of anybody in lists');
  await accessible(page, 'the list');
  const start = Date.now();
  await page.click('.case-link');
  await settled(page);
  console.log(`open a case: ${Date.now() - start} ms (target 3000)`);
}

async function lookAtImages(page) {
  await page.click('.path a:has-text("Patient")');
  await page.waitForSelector('.slices .solid canvas');
  await assertPicture(page, 'the patient in three dimensions');
  const where = () => page.textContent('.side .where');
  const first = await where(), slice = () => page.evaluate(() => document.querySelector('.slice canvas').toDataURL());
  const before = await slice(), solid = (await pixels(page)).hash;
  const box = await page.locator('.solid .viewer canvas').boundingBox();
  await page.mouse.click(box.x + 0.55 * box.width, box.y + 0.5 * box.height);
  await page.waitForTimeout(200);
  assert.notEqual(await where(), first, 'a click on the skin moves the crosshair');
  assert.match(await where(), /skin|fat|outside/);
  assert.notEqual(await slice(), before, 'and the slices');
  assert.notEqual((await pixels(page)).hash, solid, 'and the lines in 3-D');
  const axial = await page.locator('.slice canvas').first().boundingBox(), there = await where();
  await page.mouse.click(axial.x + 0.3 * axial.width, axial.y + 0.4 * axial.height);
  assert.notEqual(await where(), there, 'a click on a slice moves it, too');
  await accessible(page, 'the images');
  await shot(page, 'patient');
  await page.click('#cover');
  await page.waitForSelector('.curtain');
  assert.equal(await page.evaluate(() => document.getElementById('app').inert), true, 'covered: nothing can be reached');
  await shot(page, 'covered');
  await page.keyboard.press('Enter');
  assert.equal(await page.locator('.curtain').count(), 0);
  await page.click('.path a:has-text("Plan")');
  await settled(page);
}

async function changePlan(page) {
  await assertPicture(page, 'the plan');
  await accessible(page, 'the plan');
  await shot(page, 'plan');
  const first = await excised(page);
  assert.ok(first > 5 && first < 150, `excised ${first} cm3`);
  const before = await pixels(page);
  await slide(page, 'Margin', 5);
  const wider = await excised(page);
  assert.ok(wider > 1.2 * first, `5 mm more margin: ${first} -> ${wider} cm3`);
  assert.notEqual((await pixels(page)).hash, before.hash, 'a wider excision looks different');
  await page.keyboard.press('Control+z');
  await page.keyboard.press('Control+z');
  await page.keyboard.press('Control+z');
  await page.keyboard.press('Control+z');
  await page.keyboard.press('Control+z');
  await page.waitForTimeout(500);
  await settled(page);
  assert.equal(await excised(page), first, 'undo brings the numbers back');
  // A change while dragging: the live answer's time.
  const live = await page.evaluate(async () => {
    const slider = [...document.querySelectorAll('.panel input[type=range]')].find((i) => i.getAttribute('aria-label') === 'Margin');
    slider.value = '12';
    slider.dispatchEvent(new Event('input', { bubbles: true }));
    const numbers = document.querySelector('.numbers');
    await new Promise((done) => { const t = setInterval(() => { if (numbers.dataset.live === 'true') { clearInterval(t); done(); } }, 5); });
    return Number(numbers.dataset.ms);
  });
  console.log(`plan edit to live numbers: ${live} ms (target 200)`);
  // Place the tumour by a click, look for the time of the pick itself.
  const where = await page.textContent('.numbers .where');
  await page.click('text=Move: click on the breast');
  const box = await page.locator('.viewer canvas').boundingBox();
  await page.mouse.click(box.x + 0.62 * box.width, box.y + 0.55 * box.height);
  await page.waitForSelector('text=Depth below skin');
  await page.waitForTimeout(500);
  await settled(page);
  const pick = await page.evaluate(() => window.sanatrix.viewer.lastPickMs);
  console.log(`pick: ${pick.toFixed(1)} ms (target 16)`);
  assert.notEqual(await page.textContent('.numbers .where'), where, 'the tumour is somewhere else now');
  assert.match(await page.textContent('.numbers .where'), /^(Left|Right) breast/);
  await page.keyboard.press('Control+z');
  await page.waitForTimeout(300);
  await settled(page);
  const round = await excised(page), hash = (await pixels(page)).hash;
  await page.click('.choice span:text-is("Segment (wedge)")');
  await page.waitForTimeout(300);
  await settled(page);
  assert.ok(await excised(page) > round, `a segment holds the cylinder: ${round} -> ${await excised(page)} cm3`);
  assert.notEqual((await pixels(page)).hash, hash, 'and is seen');
  await slide(page, 'Ends from the nipple', 6);
  await shot(page, 'segment');
  await page.keyboard.press('Control+z');
  await page.click('.choice span:text-is("Cylinder")');
  await page.waitForTimeout(300);
  await settled(page);
  assert.equal(await excised(page), round, 'back at the cylinder');
  for (const name of ['Circumareolar', 'Radial', 'Fold']) {
    const was = (await pixels(page)).hash;
    await page.click(`.choice span:text-is("${name}")`);
    await page.waitForTimeout(600);
    await settled(page);
    assert.notEqual((await pixels(page)).hash, was, `the incision ${name} is seen`);
  }
  await shot(page, 'plan-changed');
}

/** A second browser, let in on its own, looks at the same plan while the first one simulates another. */
async function simulateWatchedByAnother(page) {
  const context = await browser.newContext({ viewport: { width: 1200, height: 800 } });
  const other = await context.newPage();
  other.setDefaultTimeout(minutes(2));
  await other.goto(address);
  await other.goto(page.url());
  await settled(other);
  const mine = await excised(page);
  assert.notEqual(await excised(other), mine, 'the first browser has changed its plan already');
  await page.click('#simulate');
  await other.waitForSelector('.progress [role=progressbar]');
  await other.waitForFunction((cm3) => document.querySelector('.numbers .big strong')?.textContent.startsWith(cm3), mine.toFixed(1));
  assert.ok(await other.locator('#simulate').isDisabled(), 'nobody starts a second run of one case');
  await page.waitForSelector('text=Volume of the operated region', { timeout: minutes(6) });
  await page.waitForFunction(() => !document.querySelector('.progress'), null, { timeout: minutes(6) });
  await other.waitForFunction(() => !document.querySelector('.progress'), null, { timeout: minutes(1) });
  const dots = (p) => p.locator('.path .dot.fresh').count();
  // The last states come with an answer of their own, after the progress has gone.
  for (let tries = 0; tries < 60 && (await dots(other)) !== (await dots(page)); ++tries) {
    await other.waitForTimeout(1000);
  }
  assert.equal(await dots(other), await dots(page), 'both see the same stages done');
  await context.close();
}

async function watchAndCompare(page) {
  await simulateWatchedByAnother(page);
  const dayZero = await assertPicture(page, 'healing');
  await page.getByRole('slider', { name: 'Day' }).focus();
  await page.keyboard.press('End');
  assert.notEqual(await assertPicture(page, 'healing at the end'), dayZero, 'healing changes the cut');
  await accessible(page, 'healing');
  await shot(page, 'healing');
  await page.click('.path a:has-text("Result")');
  await page.waitForSelector('.measures');
  const half = await assertPicture(page, 'the result');
  await shot(page, 'result');
  await page.click('.choice span:text-is("Change")');
  assert.notEqual(await assertPicture(page, 'the change'), half);
  await page.click('text=Arrows');
  await shot(page, 'change');
  assert.match(await page.textContent('.measures'), /Breast retraction assessment[^]*…/, 'indices come with their range');
  assert.ok(await page.locator('.what-if button').count() >= 2, 'what if she heals badly');
  await accessible(page, 'the result');
  await page.click('.path a:has-text("Plan")');
  await settled(page);
  await slide(page, 'Margin', 6);
  await page.fill('input[placeholder="Plan A"]', '<b>wide</b>');
  await page.click('#another');
  await page.waitForFunction(() => location.hash.includes('-plan/'), null, { timeout: minutes(1) });
  await page.waitForFunction(() => document.querySelector('#simulate') && !document.querySelector('#simulate').disabled, null, { timeout: minutes(3) });
  await simulate(page);
  await page.click('.path a:has-text("Compare")');
  await page.waitForFunction(() => document.querySelectorAll('.measures thead th').length === 3);
  assert.equal(await page.locator('.measures b, .pane-title b').count(), 0, 'labels never become markup');
  assert.match(await page.textContent('.measures thead'), /<b>wide<\/b>/, 'a name is shown as it was written');
  const plain = await assertPicture(page, 'two plans');
  assert.equal(await page.locator('.pane-title').count(), 2);
  await page.click('.choice span:text-is("Displacement")');
  assert.notEqual(await assertPicture(page, 'two displacements'), plain);
  await shot(page, 'compare');
  await page.click('.choice span:text-is("Difference to the first")');
  await assertPicture(page, 'the difference');
  await shot(page, 'difference');
  await accessible(page, 'the comparison');
}

async function download(page) {
  await page.click('.path a:has-text("Result")');
  await page.waitForSelector('.measures');
  const [file] = await Promise.all([page.waitForEvent('download'), page.click('#report')]);
  const html = fs.readFileSync(await file.path(), 'utf8');
  assert.match(html, /Not a medical device/);
  assert.ok(html.length > 20_000, `a whole report, not ${html.length} bytes`);
}

/** A DICOM folder is chosen, then a zip of it: both tell their series, and the zip becomes a case. */
async function createFromImages(page) {
  const dicom = path.join(process.env.SANATRIX_SHARED ?? '../shared', 'data/dev01/dicom');
  if (!fs.existsSync(dicom)) { console.log('no MRI in SANATRIX_SHARED: creation from images is not driven'); return; }
  const start = Date.now(), zip = path.join(folder, 'study.zip');
  execFileSync('python3', ['-c', 'import shutil, sys; shutil.make_archive(sys.argv[2][:-4], "zip", sys.argv[1])', dicom, zip]);
  await page.goto(`${new URL(address).origin}/#/`);
  await page.click('text=New case');
  await page.click('dialog .choice span:text-is("MRI")');
  const [asFolder, asFile] = [page.locator('dialog input[webkitdirectory]'), page.locator('dialog .two input:not([webkitdirectory])')];
  const offered = async () => {
    await page.waitForSelector('dialog .series-list input');
    assert.ok(await page.locator('dialog .series-list label').count() >= 2, 'the localizer and the MRI are listed');
    assert.match(await page.textContent('dialog .series-list'), /not chosen: [^]*localizer/);
    assert.doesNotMatch(await page.textContent('dialog .series-list label:has(:checked)'), /not chosen/);
    return page.textContent('dialog .series-list label:has(:checked)');
  };
  await asFolder.setInputFiles(dicom);
  const best = await offered();
  await asFile.setInputFiles(zip);
  await page.waitForFunction(() => !document.querySelector('dialog .series-list'));
  assert.equal(await offered(), best, 'folder and archive hold the same');
  await accessible(page, 'the series');
  await shot(page, 'series');
  await page.fill('dialog input[type=text]', 'from-images');
  await page.click('dialog button[type=submit]');
  await page.waitForSelector('.case-link:has-text("from-images")', { timeout: minutes(6) });
  await page.waitForFunction(() => !document.querySelector('.state.working'), null, { timeout: minutes(6) });
  await page.click('.case-link:has-text("from-images")');
  await page.click('.path a:has-text("Patient")');
  await page.waitForSelector('.slices .solid canvas');
  await assertPicture(page, 'the patient of the images');
  assert.equal(await page.locator('text=This case has labels only').count(), 0, 'the MRI itself is shown');
  await shot(page, 'mri');
  console.log(`from DICOM to the operating table: ${((Date.now() - start) / 1000).toFixed(0)} s`);
}

async function elsewhere() {
  const id = fs.readdirSync(path.join(folder, 'cases')).find((n) => n.startsWith('walk'));
  let page = await open([], { width: 390, height: 780 });
  await page.goto(`${new URL(address).origin}/#/case/${id}/plan`);
  await settled(page);
  await shot(page, 'phone');
  const wide = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
  assert.ok(wide <= 0, `the page is ${wide} px wider than a phone`);
  await browser.close();
  page = await open(['--disable-3d-apis']);
  await page.goto(`${new URL(address).origin}/#/case/${id}/result`);
  await page.waitForSelector('.pictures img');
  await page.waitForFunction(() => document.querySelector('.pictures img').naturalWidth > 100);
  assert.ok(await page.locator('.measures td').count() > 5, 'the numbers are there without 3-D');
  await shot(page, 'no-webgl');
  await page.click('.path a:has-text("Plan")');
  await settled(page);
  const drawn = () => page.evaluate(() => document.querySelector('.flat canvas').toDataURL());
  const narrow = await drawn();
  await slide(page, 'Margin', 4);
  assert.notEqual(await drawn(), narrow, 'the plan is drawn without WebGL, too');
  await shot(page, 'no-webgl-plan');
  await browser.close();
}

let failed = null;
try {
  const page = await open();
  await createAndPlan(page);
  await lookAtImages(page);
  await changePlan(page);
  await watchAndCompare(page);
  await download(page);
  await createFromImages(page);
  await browser.close();
  const quiet = problems.splice(0);
  assert.deepEqual(quiet, [], 'errors on the console');
  await elsewhere();
  console.log('the whole path works');
} catch (problem) {
  failed = problem;
  const page = browser?.contexts()[0]?.pages()[0];
  if (page && shots) await page.screenshot({ path: path.join(shots, 'failed.png') }).catch(() => undefined);
  console.error(problem, '\nconsole:', problems);
} finally {
  await browser?.close().catch(() => undefined);
  server.kill('SIGINT');
  await new Promise((done) => { server.once('exit', done); setTimeout(done, 30_000); });
  fs.rmSync(folder, { recursive: true, force: true });
}
process.exit(failed ? 1 : 0);
