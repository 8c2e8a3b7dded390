# tacos-framework with software rendering; see docs/how-to/install.md.
FROM python:3.12-slim

RUN apt-get update \
    && apt-get install --yes --no-install-recommends libegl1 libegl-mesa0 libgl1-mesa-dri libgl1 \
    && rm -rf /var/lib/apt/lists/*

COPY . /source
RUN pip install --no-cache-dir '/source[optuna,fronts,frames,raw,export]' /source/plugins/tacos_validation && rm -rf /source

WORKDIR /work
CMD ["tacos", "doctor"]
