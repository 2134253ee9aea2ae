"""The look of the HTML report; verdicts are told apart by their words first and by colour second."""

CSS = """
:root { --ink: #1c2430; --soft: #5b6675; --line: #dfe3e8; --paper: #fff; --tint: #f5f7f9; --accent: #10305c;
  --good: #1d7a5a; --best: #1f5fae; --bad: #b24a00; --open: #7a6200; }
@media (prefers-color-scheme: dark) { :root { --ink: #e4e8ee; --soft: #9aa5b3; --line: #333c48; --paper: #14181e;
  --tint: #1b2129; --accent: #8ab4ef; --good: #5cc79f; --best: #82b4f2; --bad: #f09a55; --open: #d8bd55; } }
* { box-sizing: border-box; }
body { margin: 0 auto; max-width: 84rem; padding: 2rem 1.25rem 5rem; color: var(--ink); background: var(--paper);
  font: 16px/1.55 "Source Serif 4", Charter, Georgia, serif; }
h1, h2, h3, nav, table, figcaption, .counts { font-family: Inter, "Segoe UI", system-ui, sans-serif; }
h1 { font-size: 1.7rem; line-height: 1.2; margin: 0 0 .4rem; letter-spacing: -.01em; }
h2 { font-size: 1.25rem; margin: 3rem 0 .6rem; padding-top: .6rem; border-top: 1px solid var(--line); }
h3 { font-size: 1rem; margin: 2rem 0 .3rem; }
p { max-width: 46rem; margin: .4rem 0 .8rem; }
nav a { margin-right: 1.2rem; }
a { color: var(--accent); }
.wide { overflow-x: auto; border: 1px solid var(--line); border-radius: 6px; }
table { border-collapse: collapse; font-size: .8rem; line-height: 1.35; width: 100%;
  font-variant-numeric: tabular-nums; }
th, td { text-align: left; vertical-align: top; padding: .4rem .6rem; border-bottom: 1px solid var(--line); }
thead th { background: var(--tint); white-space: nowrap; }
tbody th { font-weight: 600; white-space: nowrap; }
tbody tr:last-child > * { border-bottom: 0; }
td small { display: block; color: var(--soft); white-space: nowrap; }
tr.anchor > * { color: var(--soft); background: var(--tint); font-style: italic; }
#verdicts td:nth-child(2), .prose td { min-width: 13rem; }
#verdicts td:nth-child(9) { min-width: 18rem; color: var(--soft); }
#verdicts td:nth-child(3) { font-weight: 600; }
tr.matched td:nth-child(3), li.matched b { color: var(--good); }
tr.better td:nth-child(3), li.better b { color: var(--best); }
tr.worse td:nth-child(3), tr.not-reproduced td:nth-child(3), li.worse b, li.not-reproduced b { color: var(--bad); }
tr.inconclusive td:nth-child(3), li.inconclusive b { color: var(--open); }
tr.not-run > * { color: var(--soft); }
.counts { list-style: none; display: flex; flex-wrap: wrap; gap: .4rem 1.4rem; padding: 0; margin: .6rem 0 1rem; }
.counts b { font-size: 1.3rem; }
code { font: .85em/1.4 ui-monospace, "Cascadia Code", Menlo, monospace; }
details code { display: block; margin: .3rem 0; padding: .35rem .5rem; background: var(--tint); border-radius: 4px;
  min-width: 24rem; white-space: pre-wrap; overflow-wrap: anywhere; }
details ul { margin: .2rem 0; padding-left: 1rem; color: var(--soft); }
summary { cursor: pointer; color: var(--accent); }
figure { margin: 1.6rem 0 2.6rem; }
figure img { width: 100%; max-width: 56rem; background: #fff; padding: .6rem; border: 1px solid var(--line);
  border-radius: 6px; }
figcaption { font-size: .85rem; max-width: 52rem; color: var(--soft); margin-top: .5rem; }
figcaption b { color: var(--ink); }
@media print { .wide { overflow: visible; border: 0; } nav { display: none; } }
"""
