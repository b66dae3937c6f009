#!/usr/bin/env python3
"""How many frames a second the page of a run plays in headless Chromium, without a graphics card (SwiftShader).

usage: python3 perf/page_rate.py PAGE.html [SECONDS]

Asks the page itself, which counts the frames it has drawn, through Chromium's debugging pipe.
"""
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time


class Browser:
    """Chromium, asked and told as its DevTools protocol says: messages of JSON, each ended by a zero byte."""

    def __init__(self, folder):
        program = shutil.which("chromium") or sys.exit("page_rate: found no chromium; on Debian: apt-get install chromium")
        read_there, self.write = os.pipe()
        self.read, write_there = os.pipe()

        def take_pipes():
            os.dup2(read_there, 103)
            os.dup2(write_there, 104)
            os.dup2(103, 3)
            os.dup2(104, 4)

        self.process = subprocess.Popen(
            [program, "--headless=new", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
             "--ignore-gpu-blocklist", "--window-size=1280,800", f"--user-data-dir={folder}",
             "--remote-debugging-pipe", "about:blank"],
            preexec_fn=take_pipes, close_fds=False, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(read_there)
        os.close(write_there)
        self.number = 0
        self.rest = b""

    def ask(self, method, session=None, **parameters):
        self.number += 1
        message = {"id": self.number, "method": method, "params": parameters}
        if session:
            message["sessionId"] = session
        os.write(self.write, json.dumps(message).encode() + b"\0")
        while True:
            while b"\0" not in self.rest:
                more = os.read(self.read, 1 << 16)
                if not more:
                    sys.exit("page_rate: Chromium ended")
                self.rest += more
            text, self.rest = self.rest.split(b"\0", 1)
            answer = json.loads(text)
            if answer.get("id") == self.number:
                return answer["result"]


def main():
    if len(sys.argv) not in (2, 3):
        sys.exit(__doc__)
    page = pathlib.Path(sys.argv[1]).resolve(strict=True)
    seconds = float(sys.argv[2]) if len(sys.argv) == 3 else 10
    with tempfile.TemporaryDirectory() as folder:
        browser = Browser(folder)
        target = browser.ask("Target.createTarget", url=page.as_uri() + "#play")["targetId"]
        session = browser.ask("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        rates = []
        for _ in range(int(seconds)):
            time.sleep(1)
            reply = browser.ask("Runtime.evaluate", session,
                               expression="JSON.stringify([document.body.dataset.rate, document.body.dataset.step])")
            rate, step = json.loads(reply["result"]["value"])
            print(f"step {step}: {rate} frames/s", flush=True)
            if rate:
                rates.append(float(rate))
        browser.process.kill()
        browser.process.wait()
    if not rates:
        sys.exit("page_rate: the page has told no rate")
    print(f"median {sorted(rates)[len(rates) // 2]:.1f} frames/s")


main()
