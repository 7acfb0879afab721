"""A server of the page in a process of its own, and browsers without a window; `make browser` runs these tests."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ON = "PYMDR_BROWSER" in os.environ
collect_ignore_glob = [] if ON else ["*.py"]
_FLAGS = ("--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--enable-precise-memory-info")


@pytest.fixture(scope="session")
def server():
    """The process of ``pymdr explore`` and the address that it prints."""
    command = [sys.executable, "-m", "pymdr", "explore", "--no-browser"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    lines = []
    for line in process.stdout:
        lines.append(line)
        if line.startswith("http://127.0.0.1:"):
            break
    else:
        pytest.fail("".join(lines))
    process.address = line.strip()
    yield process
    process.terminate()
    rest, _ = process.communicate(timeout=30)
    # a browser that is closed while it is sent something is no fault
    tracebacks = rest.split("Traceback (most recent call last)")[1:]
    assert all("WebSocketClosedError" in one or "StreamClosedError" in one for one in tracebacks), rest


@pytest.fixture
def open_page(server, tmp_path):
    """What opens the page in a new browser; all are closed at the end, and none asked another computer."""
    from selenium import webdriver

    from browser.pages import Page

    opened = []

    def open_one(query="", size=(1400, 1200)):
        options = webdriver.ChromeOptions()
        for flag in (*_FLAGS, f"--window-size={size[0]},{size[1]}"):
            options.add_argument(flag)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
        service = webdriver.ChromeService(shutil.which("chromedriver"))
        driver = webdriver.Chrome(options=options, service=service)
        driver.set_script_timeout(120)
        opened.append(driver)
        driver.execute_cdp_cmd(
            "Browser.setDownloadBehavior", {"behavior": "allow", "downloadPath": str(tmp_path)}
        )
        return Page(driver, server.address + query, Path(tmp_path))

    yield open_one
    for driver in opened:
        driver.quit()
