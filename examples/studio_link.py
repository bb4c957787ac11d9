"""Start the studio without a browser of its own, open a scenario in it by a link, and check that the page says what
`simulate` says. The browser here is Chromium, moved by Playwright (`pip install playwright`)."""

import re
import subprocess
import sys
from shutil import which

from playwright.sync_api import sync_playwright

import helimag as hm
from helimag.studio import link_of

PORT = 8151
found = hm.load("paper/fig3c").replaced({"drive.frequency": "2.5 Hz", "run.duration": "300 s"})
command = [sys.executable, "-m", "helimag", "studio", "--no-browser", "--port", str(PORT)]

with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as studio:
    try:
        address = re.search(r"http://\S+", studio.stderr.readline())[0]
        with sync_playwright() as tool:
            chromium = tool.chromium.launch(executable_path=which("chromium"), args=["--no-sandbox", "--disable-gpu"])
            page = chromium.new_page()
            page.set_default_timeout(150_000)  # ms: kernels may have to be compiled first
            page.goto(f"{address}?s={link_of(found)}")
            page.wait_for_selector("[data-testid=verdict][data-stage=AFTERWARDS]")
            verdict, shown = page.inner_text("[data-testid=word]"), page.inner_text("[data-testid=gain]")
            page.click("[data-testid=numbers]")
            gain = page.inner_text("[data-testid=full-gain]")
            chromium.close()
    finally:
        studio.terminate()

run = hm.simulate(found)
print(f"the page: {verdict}, gain {shown}; simulate: {run.verdict}, gain {run.gain:.3f}")
assert verdict == str(run.verdict)
assert gain == repr(run.gain)  # to the last digit
