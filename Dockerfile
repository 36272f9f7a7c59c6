# docker build -t plantigrade . && docker run --rm -v "$PWD:/data" plantigrade fit walk.c3d
# The build installs the wheel alone and runs the demo, so an image that exists works.
FROM python:3.12-slim AS wheel
WORKDIR /source
COPY pyproject.toml README.md LICENSE ./
COPY plantigrade plantigrade
RUN pip wheel --no-cache-dir --no-deps --wheel-dir /wheel .

FROM python:3.12-slim
COPY --from=wheel /wheel /wheel
RUN pip install --no-cache-dir "$(ls /wheel/*.whl)[synthesis]" && rm -r /wheel \
    && useradd --create-home --uid 1000 walker && mkdir /data && chown walker /data
USER walker
RUN cd /tmp && plantigrade demo --quiet && rm -r /tmp/runs
WORKDIR /data
ENTRYPOINT ["plantigrade"]
CMD ["--help"]
